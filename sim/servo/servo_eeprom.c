#include "servo/servo_eeprom.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "output/files.h"

#define PATH_ROOM      4096
#define TEXT_ROOM      128
#define SAVES_A_SECOND 4
#define HEADING        "CDS55xx EEPROM"

/* Of the same ID the first servo has the plain name, the second one -2, ... */
static void name_file(const struct state *state, unsigned index, char path[PATH_ROOM])
{
    const struct servo_node *node = state->servos->node;
    unsigned twin = 1;
    for (unsigned i = 0; i < index; i++) {
        twin += node[i].id == node[index].id;
    }
    char number[16] = "";
    if (twin > 1) {
        snprintf(number, sizeof(number), "-%u", twin);
    }
    snprintf(path, PATH_ROOM, "%s/bus%u-servo%03u%s.eeprom", state->folder, state->bus,
             node[index].id, number);
}

/* CRC-16/CCITT, so that a file that was cut or edited is noticed. */
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

static void write_text(const uint8_t bytes[SERVO_EEPROM_SIZE], char text[TEXT_ROOM])
{
    int size = snprintf(text, TEXT_ROOM, "%s", HEADING);
    for (unsigned i = 0; i < SERVO_EEPROM_SIZE; i++) {
        size += snprintf(text + size, TEXT_ROOM - (size_t)size, " %02X", bytes[i]);
    }
    snprintf(text + size, TEXT_ROOM - (size_t)size, " CRC %04X\n", checksum(bytes));
}

/* What would be written of the bytes found must be what was found. */
static bool read_text(const char text[TEXT_ROOM], uint8_t bytes[SERVO_EEPROM_SIZE])
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
    char again[TEXT_ROOM];
    write_text(bytes, again);
    return strcmp(text, again) == 0;
}

static bool complain(const char *path, const char *what)
{
    fprintf(stderr, "%s: %s\n", path, what);
    return false;
}

static bool load(struct state *state, unsigned index)
{
    char path[PATH_ROOM];
    char text[TEXT_ROOM] = "";
    uint8_t bytes[SERVO_EEPROM_SIZE] = {0};
    name_file(state, index, path);
    FILE *file = fopen(path, "r");
    if (!file) {
        return errno == ENOENT || complain(path, strerror(errno));
    }
    size_t size = fread(text, 1, sizeof(text) - 1, file);
    fclose(file);
    text[size] = 0;
    return (read_text(text, bytes) && servos_eeprom_set(state->servos, index, bytes)) ||
           complain(path, "damaged: no EEPROM of a servo; remove the file for a servo as new");
}

bool state_load(struct state *state)
{
    for (unsigned i = 0; i < state->servos->count && state->folder; i++) {
        if (!load(state, i)) {
            return false;
        }
        servo_eeprom_get(&state->servos->node[i].servo, state->saved[i]);
    }
    return true;
}

/* Not durable: fsync() would hold up a run in real time. */
static bool replace(const struct state *state, unsigned index,
                    const uint8_t bytes[SERVO_EEPROM_SIZE])
{
    char path[PATH_ROOM];
    char text[TEXT_ROOM];
    name_file(state, index, path);
    write_text(bytes, text);
    return files_replace(path, text, strlen(text), false);
}

void state_save(struct state *state)
{
    if (!state->folder) {
        return;
    }
    for (unsigned i = 0; i < state->servos->count && !state->failed; i++) {
        uint8_t bytes[SERVO_EEPROM_SIZE];
        servo_eeprom_get(&state->servos->node[i].servo, bytes);
        if (memcmp(bytes, state->saved[i], sizeof(bytes)) != 0) {
            memcpy(state->saved[i], bytes, sizeof(bytes));
            state->failed = !replace(state, i, bytes);
        }
    }
}

static void save(void *owner, uint64_t now)
{
    struct state *state = owner;
    state_save(state);
    schedule_at(state->servos->schedule, &state->save, now + state->period);
}

bool state_init(struct state *state, const char *folder, unsigned bus, struct servos *servos)
{
    *state = (struct state){.folder = folder, .bus = bus, .servos = servos};
    if (!folder) {
        return true;
    }
    struct stat found;
    if (mkdir(folder, 0777) != 0 && errno != EEXIST) {
        return complain(folder, strerror(errno));
    }
    if (stat(folder, &found) != 0 || !S_ISDIR(found.st_mode)) {
        return complain(folder, "no folder");
    }
    state->period = servos->clock_Hz / SAVES_A_SECOND;
    event_init(&state->save, save, state);
    schedule_at(servos->schedule, &state->save, servos->schedule->now + state->period);
    return true;
}
