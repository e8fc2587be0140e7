/* SPDX-License-Identifier: MIT */
#include "servo/servo_eeprom.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "output/files.h"

#define PATH_SIZE      4096
#define TEXT_SIZE      128
#define SAVES_A_SECOND 4
#define HEADING        "CDS55xx EEPROM"

/* Of servos with the same ID the first file has the plain name, the second one ends in -2. */
static void name_file(const struct servo_eeprom *eeprom, unsigned index, char path[PATH_SIZE])
{
    const struct servo_node *node = eeprom->servos->node;
    unsigned number_of_id = 1;
    for (unsigned i = 0; i < index; i++) {
        number_of_id += node[i].id == node[index].id;
    }
    char number[16] = "";
    if (number_of_id > 1) {
        snprintf(number, sizeof(number), "-%u", number_of_id);
    }
    snprintf(path, PATH_SIZE, "%s/bus%u-servo%03u%s.eeprom", eeprom->folder, eeprom->bus,
             node[index].id, number);
}

/* CRC-16/CCITT: detects files that were cut or edited. */
static unsigned checksum(const uint8_t bytes[SERVO_EEPROM_SIZE])
{
    unsigned crc = 0xFFFF;
    for (unsigned i = 0; i < SERVO_EEPROM_SIZE; i++) {
        crc ^= (unsigned)bytes[i] << 8;
        for (unsigned bit = 0; bit < 8; bit++) {
            crc = (crc << 1 ^ (crc & 0x8000 ? 0x1021 : 0)) & 0xFFFF;
        }
    }
    return crc;
}

static void write_text(const uint8_t bytes[SERVO_EEPROM_SIZE], char text[TEXT_SIZE])
{
    int size = snprintf(text, TEXT_SIZE, "%s", HEADING);
    for (unsigned i = 0; i < SERVO_EEPROM_SIZE; i++) {
        size += snprintf(text + size, TEXT_SIZE - (size_t)size, " %02X", bytes[i]);
    }
    snprintf(text + size, TEXT_SIZE - (size_t)size, " CRC %04X\n", checksum(bytes));
}

/* The text is valid if writing its bytes gives the same text. */
static bool read_text(const char text[TEXT_SIZE], uint8_t bytes[SERVO_EEPROM_SIZE])
{
    const char *next = text + strlen(HEADING);
    for (unsigned i = 0; i < SERVO_EEPROM_SIZE; i++) {
        unsigned byte = 0;
        if (sscanf(next, " %2X", &byte) != 1) {
            return false;
        }
        bytes[i] = (uint8_t)byte;
        next += 3;
    }
    char again[TEXT_SIZE];
    write_text(bytes, again);
    return strcmp(text, again) == 0;
}

static bool load(struct servo_eeprom *eeprom, unsigned index)
{
    char path[PATH_SIZE];
    char text[TEXT_SIZE] = "";
    uint8_t bytes[SERVO_EEPROM_SIZE] = {0};
    name_file(eeprom, index, path);
    FILE *file = fopen(path, "r");
    if (!file) {
        return errno == ENOENT || files_complain(path, strerror(errno));
    }
    size_t size = fread(text, 1, sizeof(text) - 1, file);
    fclose(file);
    text[size] = 0;
    return (read_text(text, bytes) && servos_set_eeprom(eeprom->servos, index, bytes)) ||
           files_complain(path,
                          "damaged: no EEPROM of a servo; remove the file for a servo as new");
}

bool servo_eeprom_load(struct servo_eeprom *eeprom)
{
    for (unsigned i = 0; i < eeprom->servos->count && eeprom->folder; i++) {
        if (!load(eeprom, i)) {
            return false;
        }
        servo_get_eeprom(&eeprom->servos->node[i].servo, eeprom->saved[i]);
    }
    return true;
}

/* Not durable: fsync() would delay a run in real time. */
static bool replace(const struct servo_eeprom *eeprom, unsigned index,
                    const uint8_t bytes[SERVO_EEPROM_SIZE])
{
    char path[PATH_SIZE];
    char text[TEXT_SIZE];
    name_file(eeprom, index, path);
    write_text(bytes, text);
    return files_replace(path, text, strlen(text), false);
}

void servo_eeprom_save(struct servo_eeprom *eeprom)
{
    if (!eeprom->folder) {
        return;
    }
    for (unsigned i = 0; i < eeprom->servos->count && !eeprom->failed; i++) {
        uint8_t bytes[SERVO_EEPROM_SIZE];
        servo_get_eeprom(&eeprom->servos->node[i].servo, bytes);
        if (memcmp(bytes, eeprom->saved[i], sizeof(bytes)) != 0) {
            memcpy(eeprom->saved[i], bytes, sizeof(bytes));
            eeprom->failed = !replace(eeprom, i, bytes);
        }
    }
}

static void save(void *context, uint64_t now)
{
    struct servo_eeprom *eeprom = context;
    servo_eeprom_save(eeprom);
    schedule_at(eeprom->servos->schedule, &eeprom->save, now + eeprom->period);
}

bool servo_eeprom_init(struct servo_eeprom *eeprom, const char *folder, unsigned bus,
                       struct servos *servos)
{
    *eeprom = (struct servo_eeprom){.folder = folder, .bus = bus, .servos = servos};
    if (!folder) {
        return true;
    }
    struct stat found;
    if (mkdir(folder, 0777) != 0 && errno != EEXIST) {
        return files_complain_of_output(folder);
    }
    if (stat(folder, &found) != 0 || !S_ISDIR(found.st_mode)) {
        return files_complain(folder, "no folder");
    }
    eeprom->period = servos->clock_Hz / SAVES_A_SECOND;
    event_init(&eeprom->save, save, eeprom);
    schedule_at(servos->schedule, &eeprom->save, servos->schedule->now + eeprom->period);
    return true;
}
