/* SPDX-License-Identifier: MIT */
#include "servo/servo.h"

#include <string.h>

#define TICKS_PER_SECOND 250
#define BLINK_TICKS      62 // lit for 62 ticks, then dark for 62 ticks

enum instruction {
    PING = 0x01,
    READ = 0x02,
    WRITE = 0x03,
    REG_WRITE = 0x04,
    ACTION = 0x05,
    RESET = 0x06,
    SYNC_WRITE = 0x83,
};

static uint16_t word(const uint8_t *registers, uint8_t address)
{
    return table_get(registers, address, 2);
}

static bool endless(const struct servo *servo) // R16
{
    return word(servo->registers, TABLE_CW_LIMIT) == 0 &&
           word(servo->registers, TABLE_CCW_LIMIT) == 0;
}

static bool baud_is_listed(uint8_t baud)
{
    static const uint8_t listed[] = {1, 3, 7, 16, 34, 103};
    return memchr(listed, baud, sizeof listed) != NULL;
}

/* Returns the conditions that hold now (R18). */
static uint8_t conditions(const struct servo *servo)
{
    const uint8_t *now = servo->registers;
    uint8_t voltage = now[TABLE_PRESENT_VOLTAGE];
    bool bad_voltage = voltage < now[TABLE_LOWEST_VOLTAGE] || voltage > now[TABLE_HIGHEST_VOLTAGE];
    bool hot = now[TABLE_PRESENT_TEMPERATURE] > now[TABLE_HIGHEST_TEMPERATURE];
    return (uint8_t)((bad_voltage ? SERVO_ERROR_VOLTAGE : 0) | (hot ? SERVO_ERROR_OVERHEATING : 0) |
                     (servo->motor.overload ? SERVO_ERROR_OVERLOAD : 0));
}

/* R17: a shutdown disables torque until it is enabled again. An overload does not shut down; the
 * motor lowers its torque. */
static void update_alarms(struct servo *servo)
{
    unsigned alarms = servo_errors(servo) & servo->registers[TABLE_ALARM_SHUTDOWN];
    if (alarms & (unsigned)~SERVO_ERROR_OVERLOAD) {
        servo->registers[TABLE_TORQUE_ENABLE] = 0;
    }
}

static void update_present_values(struct servo *servo)
{
    uint8_t *now = servo->registers;
    table_set(now, TABLE_PRESENT_POSITION, 2, motor_present_position(&servo->motor));
    table_set(now, TABLE_PRESENT_SPEED, 2, motor_present_speed(&servo->motor));
    table_set(now, TABLE_PRESENT_LOAD, 2, motor_present_load(&servo->motor));
    now[TABLE_PRESENT_TEMPERATURE] = motor_present_temperature(&servo->motor);
    now[TABLE_PRESENT_VOLTAGE] = servo->environment.supply_dV;
    now[TABLE_MOVING] = servo->motor.moving;
}

/* Sets the RAM area to its initial values (R38). */
static void initialise_ram(struct servo *servo)
{
    motor_release(&servo->motor);
    table_initialise(servo->registers, false);
    update_present_values(servo);
    memcpy(servo->registers + TABLE_GOAL_POSITION, servo->registers + TABLE_PRESENT_POSITION, 2);
}

/* --- writing --- */

static uint16_t highest_value(const struct servo *servo, const struct table_row *row)
{
    if (row->address == TABLE_MOVING_SPEED && endless(servo)) {
        return 0x7FF; // R16: bit 10 is the direction
    }
    if (row->address == TABLE_REGISTERED) {
        return servo->registers[TABLE_REGISTERED]; // R39: 1 only while it is 1
    }
    return row->highest;
}

static bool is_locked(const struct servo *servo, uint8_t address) // R6
{
    return servo->registers[TABLE_LOCK] && (address < TABLE_TORQUE_ENABLE || address > TABLE_DCC);
}

static bool overlaps(const struct table_row *row, uint8_t address, unsigned count)
{
    return row->address < address + count && row->address + row->width > address;
}

/* Stores in `after` the registers that the write leaves. Returns the error bits: after a range
 * error no byte is stored (R4, R5); an angle error leaves the goal as it was (R15). */
static uint8_t try_write(const struct servo *servo, uint8_t address, const uint8_t *data,
                         unsigned count, uint8_t after[SERVO_REGISTERS])
{
    if (address + count > SERVO_REGISTERS) {
        return SERVO_ERROR_RANGE;
    }
    memcpy(after, servo->registers, SERVO_REGISTERS);
    memcpy(after + address, data, count);
    for (const struct table_row *row = table_rows; row < table_rows + TABLE_ROWS; row++) {
        if (overlaps(row, address, count) &&
            (!row->writable || is_locked(servo, row->address) ||
             table_get(after, row->address, row->width) > highest_value(servo, row))) {
            return SERVO_ERROR_RANGE;
        }
    }
    bool goal = address <= TABLE_GOAL_POSITION + 1 && address + count > TABLE_GOAL_POSITION;
    uint16_t position = word(after, TABLE_GOAL_POSITION);
    if (goal && !endless(servo) &&
        (position < word(after, TABLE_CW_LIMIT) || position > word(after, TABLE_CCW_LIMIT))) {
        memcpy(after + TABLE_GOAL_POSITION, servo->registers + TABLE_GOAL_POSITION, 2);
        return SERVO_ERROR_ANGLE;
    }
    return 0;
}

static uint8_t write_registers(struct servo *servo, uint8_t address, const uint8_t *data,
                               unsigned count)
{
    uint8_t after[SERVO_REGISTERS];
    uint8_t error = try_write(servo, address, data, count, after);
    if (error & SERVO_ERROR_RANGE) {
        return error;
    }
    memcpy(servo->registers, after, sizeof after);
    if (baud_is_listed(after[TABLE_BAUD])) {
        servo->saved_baud = after[TABLE_BAUD];
    }
    return error;
}

/* The instructions. Each returns the error bits of its packet. */

static uint8_t do_ping(struct servo *servo, const struct codec_packet *packet)
{
    (void)servo, (void)packet;
    return 0;
}

/* Checks the range. process_good() adds the parameters to the reply. */
static uint8_t do_read(struct servo *servo, const struct codec_packet *packet)
{
    (void)servo;
    unsigned address = packet->parameters[0], count = packet->parameters[1];
    return count == 0 || address + count > SERVO_REGISTERS ? SERVO_ERROR_RANGE : 0;
}

static uint8_t do_write(struct servo *servo, const struct codec_packet *packet)
{
    return write_registers(servo, packet->parameters[0], packet->parameters + 1,
                           packet->count - 1u);
}

static uint8_t do_reg_write(struct servo *servo, const struct codec_packet *packet)
{
    uint8_t after[SERVO_REGISTERS];
    unsigned count = packet->count - 1u;
    uint8_t error = try_write(servo, packet->parameters[0], packet->parameters + 1, count, after);
    if (error == 0) {
        servo->registered.address = packet->parameters[0];
        servo->registered.count = (uint8_t)count;
        memcpy(servo->registered.data, packet->parameters + 1, count);
        servo->registers[TABLE_REGISTERED] = 1;
    }
    return error;
}

static uint8_t do_action(struct servo *servo, const struct codec_packet *packet)
{
    (void)packet;
    if (!servo->registers[TABLE_REGISTERED]) {
        return SERVO_ERROR_INSTRUCTION;
    }
    servo->registers[TABLE_REGISTERED] = 0;
    return write_registers(servo, servo->registered.address, servo->registered.data,
                           servo->registered.count);
}

static uint8_t do_reset(struct servo *servo, const struct codec_packet *packet)
{
    (void)packet;
    if (servo->registers[TABLE_LOCK]) {
        return SERVO_ERROR_RANGE; // R37
    }
    table_initialise(servo->registers, true);
    servo->saved_baud = SERVO_RESET_BAUD;
    initialise_ram(servo);
    return 0;
}

static uint8_t do_sync_write(struct servo *servo, const struct codec_packet *packet)
{
    unsigned count = packet->parameters[1], block = count + 1, mine = 0;
    if (packet->id != SERVO_BROADCAST_ID || count == 0 || (packet->count - 2u) % block != 0) {
        return SERVO_ERROR_INSTRUCTION; // R22, R34
    }
    for (unsigned at = 2; at < packet->count; at += block) {
        if (packet->parameters[at] == servo->registers[TABLE_ID]) {
            mine = at; // R22: the last block with this ID applies
        }
    }
    if (mine == 0) {
        return 0;
    }
    return write_registers(servo, packet->parameters[0], packet->parameters + mine + 1, count);
}

struct instruction_row {
    uint8_t instruction;
    uint8_t parameters_min, parameters_max; // number of parameters (R34)
    uint8_t reply_level; // lowest status return level at which the servo replies (R1, R3)
    uint8_t (*execute)(struct servo *servo, const struct codec_packet *packet);
};

static const struct instruction_row *find_instruction(uint8_t instruction)
{
    static const struct instruction_row rows[] = {
        {PING, 0, 0, 0, do_ping},
        {READ, 2, 2, 1, do_read},
        {WRITE, 2, UINT8_MAX, 2, do_write},
        {REG_WRITE, 2, UINT8_MAX, 2, do_reg_write},
        {ACTION, 0, 0, 2, do_action},
        {RESET, 0, 0, 2, do_reset},
        {SYNC_WRITE, 4, UINT8_MAX, 2, do_sync_write},
        {0}, // any other instruction is undefined
    };
    const struct instruction_row *row = rows;
    while (row->execute && row->instruction != instruction) {
        row++;
    }
    return row;
}

/* --- packets --- */

static uint32_t jitter_us(struct servo_quirks *quirks)
{
    quirks->seed ^= quirks->seed << 13;
    quirks->seed ^= quirks->seed >> 17;
    quirks->seed ^= quirks->seed << 5;
    return quirks->seed % (quirks->jitter_us + 1u);
}

/* The registers on arrival of the packet decide whether and how the servo replies (R2). */
struct arrival {
    uint8_t id;
    uint8_t level;
    uint8_t baud;
    uint32_t delay_us;
};

static struct arrival arrive(const struct servo *servo)
{
    return (struct arrival){
        .id = servo->registers[TABLE_ID],
        .level = servo->registers[TABLE_RETURN_LEVEL],
        .baud = servo->registers[TABLE_BAUD],
        .delay_us = servo->registers[TABLE_RETURN_DELAY] * 2u,
    };
}

static void build_reply(struct servo *servo, const struct arrival *arrival,
                        const uint8_t *parameters, uint8_t count)
{
    struct servo_reply *reply = &servo->reply;
    reply->delay_us =
        arrival->delay_us + servo->quirks.extra_turnaround_us + jitter_us(&servo->quirks);
    reply->baud = arrival->baud;
    reply->size = codec_status(reply->bytes, arrival->id, servo_errors(servo), parameters, count);
}

/* R19: a servo never executes a damaged packet. It replies if the packet has its ID. */
static bool process_damaged(struct servo *servo, const struct codec_packet *packet)
{
    struct arrival arrival = arrive(servo);
    servo->packet_error = SERVO_ERROR_CHECKSUM;
    update_alarms(servo);
    if (packet->id != arrival.id || arrival.level < 2) {
        return false;
    }
    build_reply(servo, &arrival, NULL, 0);
    return true;
}

static bool process_good(struct servo *servo, const struct codec_packet *packet)
{
    struct arrival arrival = arrive(servo);
    const struct instruction_row *row = find_instruction(packet->instruction);
    bool sound = row->execute && packet->count >= row->parameters_min &&
                 packet->count <= row->parameters_max;
    servo->packet_error = sound ? row->execute(servo, packet) : SERVO_ERROR_INSTRUCTION;
    update_alarms(servo);

    uint8_t reply_level = row->execute ? row->reply_level : 2;
    bool silent = packet->id == SERVO_BROADCAST_ID && packet->instruction != PING;
    if (silent || arrival.level < reply_level) {
        return false;
    }
    if (packet->instruction == READ && servo->packet_error == 0) {
        build_reply(servo, &arrival, servo->registers + packet->parameters[0],
                    packet->parameters[1]);
    } else {
        build_reply(servo, &arrival, NULL, 0);
    }
    return true;
}

static bool process_packet(struct servo *servo, enum codec_event event,
                           const struct codec_packet *packet)
{
    if (packet->id != servo->registers[TABLE_ID] && packet->id != SERVO_BROADCAST_ID) {
        return false;
    }
    if (servo->quirks.sync_write_limit && packet->instruction == SYNC_WRITE &&
        packet->size > SERVO_SYNC_WRITE_LIMIT) {
        return false;
    }
    return event == CODEC_PACKET ? process_good(servo, packet) : process_damaged(servo, packet);
}

void servo_silence(struct servo *servo, uint64_t us)
{
    if (us >= SERVO_PACKET_TIMEOUT_US) {
        codec_reset(&servo->codec);
    } else if (us >= SERVO_PAUSE_US) {
        codec_pause(&servo->codec);
    }
}

bool servo_receive(struct servo *servo, uint8_t byte, bool framing_error)
{
    bool asleep = servo->quirks.silent_after_power_up && servo->ticks < TICKS_PER_SECOND;
    if (!servo->powered || asleep) {
        return false;
    }
    if (framing_error) {
        codec_reset(&servo->codec);
        return false;
    }
    codec_put(&servo->codec, byte);

    bool due = false;
    struct codec_packet packet;
    enum codec_event event;
    while ((event = codec_next(&servo->codec, &packet)) != CODEC_NOTHING) {
        due |= process_packet(servo, event, &packet);
    }
    return due;
}

/* --- time and power --- */

static struct motor_command motor_command(const struct servo *servo)
{
    const uint8_t *now = servo->registers;
    uint16_t speed = word(now, TABLE_MOVING_SPEED);
    return (struct motor_command){
        .torque = now[TABLE_TORQUE_ENABLE],
        .endless = endless(servo),
        .clockwise = speed & 0x400,
        .speed = speed & 0x3FF,
        .goal = word(now, TABLE_GOAL_POSITION),
        .torque_limit = servo->torque_limit,
        .punch = word(now, TABLE_PUNCH),
        .acc = now[TABLE_ACC],
        .dcc = now[TABLE_DCC],
        .cw_margin = now[TABLE_CW_MARGIN],
        .ccw_margin = now[TABLE_CCW_MARGIN],
        .cw_proportion = now[TABLE_CW_PROPORTION],
        .ccw_proportion = now[TABLE_CCW_PROPORTION],
    };
}

void servo_tick(struct servo *servo)
{
    struct motor_command command = motor_command(servo);
    motor_step(&servo->motor, &command, &servo->environment);
    servo->ticks++;
    update_present_values(servo);
    update_alarms(servo);
}

void servo_power(struct servo *servo, bool on)
{
    servo->powered = on;
    servo->registers[TABLE_BAUD] = servo->saved_baud;
    servo->torque_limit = word(servo->registers, TABLE_MAX_TORQUE);
    servo->packet_error = 0;
    servo->ticks = 0;
    codec_reset(&servo->codec);
    initialise_ram(servo);
}

void servo_init(struct servo *servo, uint8_t id)
{
    *servo = (struct servo){
        .environment = {.supply_dV = 120, .ambient_C = 32},
        .quirks = {.seed = 1u + id},
        .saved_baud = SERVO_RESET_BAUD,
    };
    table_initialise(servo->registers, true);
    servo->registers[TABLE_ID] = id;
    motor_init(&servo->motor, 512, &servo->environment);
    servo_power(servo, true);
}

void servo_get_eeprom(const struct servo *servo, uint8_t bytes[SERVO_EEPROM_SIZE])
{
    memcpy(bytes, servo->registers, SERVO_EEPROM_SIZE);
    bytes[TABLE_BAUD] = servo->saved_baud;
}

bool servo_set_eeprom(struct servo *servo, const uint8_t bytes[SERVO_EEPROM_SIZE])
{
    uint8_t found[SERVO_REGISTERS];
    memcpy(found, servo->registers, sizeof found);
    for (const struct table_row *row = table_rows; row->eeprom; row++) {
        uint16_t value = table_get(bytes, row->address, row->width);
        if (row->writable && value > row->highest) {
            return false;
        }
        if (row->writable) {
            table_set(found, row->address, row->width, value);
        }
    }
    if (!baud_is_listed(found[TABLE_BAUD])) {
        return false;
    }
    memcpy(servo->registers, found, sizeof found);
    servo->saved_baud = found[TABLE_BAUD];
    servo_power(servo, servo->powered);
    return true;
}

/* --- state --- */

uint8_t servo_baud(const struct servo *servo)
{
    return servo->registers[TABLE_BAUD];
}

uint8_t servo_errors(const struct servo *servo)
{
    return conditions(servo) | servo->packet_error;
}

uint16_t servo_goal_position(const struct servo *servo)
{
    return word(servo->registers, TABLE_GOAL_POSITION);
}

uint16_t servo_present_position(const struct servo *servo)
{
    return word(servo->registers, TABLE_PRESENT_POSITION);
}

/* Bits 0-9 are the magnitude, bit 10 is CW (R35). */
static int16_t with_sign(uint16_t value)
{
    return (int16_t)(value & 0x400 ? -(value & 0x3FF) : value & 0x3FF);
}

int16_t servo_present_speed(const struct servo *servo)
{
    return with_sign(word(servo->registers, TABLE_PRESENT_SPEED));
}

int16_t servo_present_load(const struct servo *servo)
{
    return with_sign(word(servo->registers, TABLE_PRESENT_LOAD));
}

int32_t servo_position_milliunits(const struct servo *servo)
{
    return servo->motor.position / 1000;
}

bool servo_torque(const struct servo *servo)
{
    return servo->registers[TABLE_TORQUE_ENABLE] && servo->torque_limit > 0;
}

enum servo_lamp servo_lamp(const struct servo *servo)
{
    if (!servo->powered) {
        return SERVO_LAMP_OFF;
    }
    if (servo_errors(servo) & servo->registers[TABLE_ALARM_LED]) {
        return SERVO_LAMP_BLINKING;
    }
    return servo->registers[TABLE_LED] ? SERVO_LAMP_ON : SERVO_LAMP_OFF;
}

bool servo_led(const struct servo *servo)
{
    enum servo_lamp lamp = servo_lamp(servo);
    return lamp == SERVO_LAMP_BLINKING ? servo->ticks / BLINK_TICKS % 2 == 0
                                       : lamp == SERVO_LAMP_ON;
}
