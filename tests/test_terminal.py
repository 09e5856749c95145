"""What commands say: lines that no terminal obeys."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tunneller_lib.__main__ import main
from tunneller_lib.terminal import fit

OBEYED = "a\x1b[2Jb\r\x07\n\x85\u202ec"  # clears, returns, rings, turns the writing's direction


@given(st.text(st.characters()), st.integers(10, 60))
def test_any_text_becomes_one_printable_line_of_bounded_length(text, most):
    line = fit(text, most)
    assert line.isprintable() and len(line) <= most
    if text.isprintable() and len(text) <= most:
        assert line == text


@pytest.mark.parametrize("arguments", [("cut", f"{OBEYED}.toml"), (OBEYED,)])
def test_a_name_that_a_terminal_would_obey_is_spelled_out(capsys, arguments):
    try:
        code = main([str(one) for one in arguments])
    except SystemExit as end:  # of wrong usage
        code = end.code
    said, told = capsys.readouterr()
    assert code == 2 and said == ""
    assert all(line.isprintable() for line in told.split("\n"))
    assert "\\x1b[2J" in told and len(told) < 1200
