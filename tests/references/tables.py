"""How the tables of this folder are written and read: one header line, and row by row."""

import csv


def write(table, columns, rows):
    """Write a table, a row as soon as it's known."""
    with table.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        for row in rows:
            writer.writerow(row)
            file.flush()


def read(table):
    """Return a table's header and its rows, lists of texts."""
    with table.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return header, rows
