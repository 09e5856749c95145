/* Run a firmware in simavr and print its marks: @ what began, + its cycles, = a value that it said. */
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

enum { GPIOR0 = 0x3E, GPIOR1 = 0x4A };  /* of the ATmega328P, in the data space */

static uint64_t begun;
static int what, bytes;
static uint32_t value;

static void marked(avr_t *avr, avr_io_addr_t address, uint8_t mark, void *unused)
{
    (void)unused;
    avr->data[address] = mark;
    if (mark) {
        what = mark;
        begun = avr->cycle;
    } else {
        printf("@%d\n+%d\n", what, (int)(avr->cycle - begun));
    }
}

static void told(avr_t *avr, avr_io_addr_t address, uint8_t byte, void *unused)
{
    (void)unused;
    avr->data[address] = byte;
    value = value >> 8 | (uint32_t)byte << 24;
    if (++bytes % 4 == 0) printf("=%d\n", (int)(int32_t)value);
}

int main(int count, char **given)
{
    elf_firmware_t firmware = {{0}};
    if (count != 2 || elf_read_firmware(given[1], &firmware)) return 2;
    avr_t *avr = avr_make_mcu_by_name("atmega328p");
    if (!avr) return 2;
    avr_init(avr);
    avr->log = LOG_ERROR;
    avr->frequency = 16000000;
    avr_load_firmware(avr, &firmware);
    avr_register_io_write(avr, GPIOR0, marked, NULL);
    avr_register_io_write(avr, GPIOR1, told, NULL);
    int state = cpu_Running;
    while (state != cpu_Done && state != cpu_Crashed) state = avr_run(avr);
    return state == cpu_Crashed;
}
