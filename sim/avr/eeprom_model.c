/* SPDX-License-Identifier: MIT */
#include "avr/eeprom_model.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "avr/cpu.h"
#include "output/files.h"

/* These bits are the same in every AVR. */
enum { EECR_EERE = 0x01, EECR_EEPE = 0x02, EECR_EEMPE = 0x04, EECR_EERIE = 0x08, EECR_EEPM = 0x30 };
enum { ERASE_AND_WRITE, ERASE, WRITE };

#define ARMED_CYCLES 4 // EEMPE stays set
#define READ_CYCLES  4 // the CPU stops for a read
#define HALT_CYCLES  2 // the CPU stops when a write begins
#define STORE_CYCLES 1 // simavr calls at the start of the instruction that writes a register
#define SLOW_US      8500
#define WHOLE_US     3400
#define HALF_US      1800
#define ERASED       0xFF
#define LOWER_HALF   0x0F
#define UPPER_HALF   0xF0

static uint8_t *eecr(const struct eeprom_model *eeprom)
{
    return &eeprom->avr->data[eeprom->registers->r_eecr];
}

static bool busy(const struct eeprom_model *eeprom)
{
    return event_armed(&eeprom->done);
}

static bool has_modes(const struct eeprom_model *eeprom)
{
    return eeprom->registers->eepm[0].reg != 0;
}

static void update_ready_interrupt(struct eeprom_model *eeprom)
{
    cpu_set_level_interrupt(eeprom->avr, &eeprom->registers->ready,
                            (*eecr(eeprom) & EECR_EERIE) && !busy(eeprom));
}

static void vector_entered(struct avr_irq_t *irq, uint32_t value, void *param)
{
    (void)irq;
    if (!value) {
        update_ready_interrupt(param);
    }
}

static void disarm(void *context, uint64_t now)
{
    (void)now;
    struct eeprom_model *eeprom = context;
    *eecr(eeprom) &= (uint8_t)~EECR_EEMPE;
}

static void written(void *context, uint64_t now)
{
    (void)now;
    struct eeprom_model *eeprom = context;
    eeprom->registers->eeprom[eeprom->address] = eeprom->value;
    *eecr(eeprom) &= (uint8_t)~EECR_EEPE;
    update_ready_interrupt(eeprom);
}

static uint16_t address(const struct eeprom_model *eeprom)
{
    const avr_eeprom_t *r = eeprom->registers;
    unsigned high = r->r_eearh ? eeprom->avr->data[r->r_eearh] : 0u;
    return (uint16_t)((high << 8 | eeprom->avr->data[r->r_eearl]) & (r->size - 1u));
}

static void begin_write(struct eeprom_model *eeprom, unsigned mode)
{
    static const struct {
        uint32_t us;
        uint8_t ignores_data,
            ignores_old; // masks: bits of EEDR, and of the old byte, that count as 1
    } modes[] = {
        [ERASE_AND_WRITE] = {WHOLE_US, 0x00, ERASED},
        [ERASE] = {HALF_US, ERASED, ERASED},
        [WRITE] = {HALF_US, 0x00, 0x00},
    };
    const avr_eeprom_t *r = eeprom->registers;
    uint32_t us = has_modes(eeprom) ? modes[mode].us : SLOW_US;
    uint64_t start = eeprom->avr->cycle + STORE_CYCLES;
    uint64_t duration = (uint64_t)us * eeprom->avr->frequency / 1000000u;
    eeprom->address = address(eeprom);
    unsigned data = eeprom->avr->data[r->r_eedr] | modes[mode].ignores_data;
    eeprom->value = (uint8_t)(data & (r->eeprom[eeprom->address] | modes[mode].ignores_old));
    eeprom->start = start;
    eeprom->whole = mode == ERASE_AND_WRITE;
    schedule_cancel(eeprom->schedule, &eeprom->disarm);
    schedule_at(eeprom->schedule, &eeprom->done, start + duration);
    cpu_halt(eeprom->avr, HALT_CYCLES);
    if (eeprom->on_write) {
        eeprom->on_write(eeprom->context, start, duration);
    }
}

static void write_eecr(avr_t *avr, avr_io_addr_t at, uint8_t value, void *param)
{
    (void)at;
    struct eeprom_model *eeprom = param;
    unsigned old = *eecr(eeprom);
    unsigned mode = busy(eeprom) ? old & EECR_EEPM : has_modes(eeprom) ? value & EECR_EEPM : 0u;
    bool armed = old & EECR_EEMPE;
    unsigned flags = mode | (value & EECR_EERIE);
    if (armed && (value & EECR_EEPE) && !busy(eeprom) && mode != EECR_EEPM) {
        begin_write(eeprom, mode >> 4);
    } else if (armed || ((value & EECR_EEMPE) && !(value & EECR_EEPE))) {
        flags |= value & EECR_EEMPE;
        if (!armed) {
            schedule_at(eeprom->schedule, &eeprom->disarm,
                        avr->cycle + STORE_CYCLES + ARMED_CYCLES);
        }
    }
    if ((value & EECR_EERE) && !busy(eeprom)) {
        avr->data[eeprom->registers->r_eedr] = eeprom->registers->eeprom[address(eeprom)];
        cpu_halt(avr, READ_CYCLES);
    }
    *eecr(eeprom) = (uint8_t)(flags | (busy(eeprom) ? EECR_EEPE : 0u));
    update_ready_interrupt(eeprom);
}

static void write_eear(avr_t *avr, avr_io_addr_t at, uint8_t value, void *param)
{
    if (!busy(param)) {
        avr->data[at] = value;
    }
}

static void take_register(struct eeprom_model *eeprom, avr_io_addr_t at, avr_io_write_t write)
{
    eeprom->avr->io[AVR_DATA_TO_IO(at)].w.c = write;
    eeprom->avr->io[AVR_DATA_TO_IO(at)].w.param = eeprom;
}

void eeprom_model_init(struct eeprom_model *eeprom, avr_t *avr, struct schedule *schedule,
                       bool exact)
{
    *eeprom = (struct eeprom_model){.avr = avr, .schedule = schedule, .exact = exact};
    event_init(&eeprom->disarm, disarm, eeprom);
    event_init(&eeprom->done, written, eeprom);
    for (avr_io_t *io = avr->io_port; io; io = io->next) {
        if (strcmp(io->kind, "eeprom") == 0) {
            eeprom->registers = (avr_eeprom_t *)io;
        }
    }
    if (!eeprom->registers || !exact) {
        return;
    }
    avr_eeprom_t *r = eeprom->registers;
    take_register(eeprom, r->r_eecr, write_eecr);
    take_register(eeprom, r->r_eearl, write_eear);
    if (r->r_eearh) {
        take_register(eeprom, r->r_eearh, write_eear);
    }
    avr_irq_register_notify(r->ready.irq + AVR_INT_IRQ_PENDING, vector_entered, eeprom);
}

void eeprom_model_reset(struct eeprom_model *eeprom)
{
    schedule_cancel(eeprom->schedule, &eeprom->disarm);
    if (eeprom->registers && busy(eeprom)) {
        *eecr(eeprom) |= EECR_EEPE;
    }
}

void eeprom_model_lose_power(struct eeprom_model *eeprom, uint64_t now)
{
    if (busy(eeprom) && eeprom->whole) {
        uint8_t *byte = &eeprom->registers->eeprom[eeprom->address];
        uint64_t percent = (now - eeprom->start) * 100u / (eeprom->done.time - eeprom->start);
        if (percent >= 90) {
            *byte = eeprom->value | UPPER_HALF;
        } else if (percent >= 50) {
            *byte = ERASED;
        } else if (percent >= 45) {
            *byte |= LOWER_HALF;
        }
    }
    schedule_cancel(eeprom->schedule, &eeprom->done);
}

/* --- file --- */

bool eeprom_model_load(struct eeprom_model *eeprom, const char *path)
{
    if (!eeprom->registers) {
        return files_complain(path, "the chip has no EEPROM");
    }
    if (!files_check_replaceable(path)) {
        return false;
    }
    FILE *file = fopen(path, "rb");
    if (!file) {
        return errno == ENOENT || files_complain(path, strerror(errno));
    }
    uint8_t bytes[UINT16_MAX];
    size_t size = fread(bytes, 1, sizeof(bytes), file);
    fclose(file);
    if (size != eeprom->registers->size) {
        fprintf(stderr, "%s: holds %zu bytes, the EEPROM of an %s has %u\n", path, size,
                eeprom->avr->mmcu, eeprom->registers->size);
        return false;
    }
    memcpy(eeprom->registers->eeprom, bytes, size);
    return true;
}

bool eeprom_model_save(const struct eeprom_model *eeprom, const char *path)
{
    return files_replace(path, eeprom->registers->eeprom, eeprom->registers->size, true);
}
