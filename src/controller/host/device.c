/* SPDX-License-Identifier: MIT */
/* The virtual device; see device.h. */
#include "host/device.h"

#include <string.h>

#include "cds55xx/packet.h" // CDS_AT_*
#include "cds55xx/version.h"
#include "compiler.h" // NOINLINE
#include "flash.h"

/* Registers that one call looks at: a READ of all registers must not hold up the bus. */
#define READ_PER_CALL 8

enum access { RD, RW } __attribute__((packed));

/* A row of the register table. */
struct row {
    uint8_t address, bytes, access;
};

static const CDS_FLASH struct row rows[DEVICE_REGISTER_COUNT] = {
#define ROW(name, address, bytes, access, lowest, highest, unit, what) {address, bytes, access},
    DEVICE_REGISTERS(ROW)
#undef ROW
};

/* The values of a register that may be written. The table ends with the last such register. */
static const CDS_FLASH struct {
    uint16_t lowest, highest;
} ranges[] = {
#define RANGE_RD(name, lowest, highest)
#define RANGE_RW(name, lowest, highest) [DEVICE_##name] = {lowest, highest},
#define RANGE(name, address, bytes, access, lowest, highest, unit, what)                           \
    RANGE_##access(name, lowest, highest)
    DEVICE_REGISTERS(RANGE)
#undef RANGE
};

uint8_t device_id(const struct device *device)
{
    return (uint8_t)device->ops->get(device->context, DEVICE_ID);
}

void device_forget_failures(struct device *device)
{
    device->failed = 0;
    memset(device->failed_ids, 0, sizeof device->failed_ids);
}

void device_note_failure(struct device *device, uint8_t id)
{
    if (device->failed < UINT8_MAX)
        device->failed++;
    device->failed_ids[id >> 3] = (uint8_t)(device->failed_ids[id >> 3] | 1u << (id & 7));
}

static uint16_t value_of(const struct device *device, uint8_t reg)
{
    static const CDS_FLASH char version[] = CDS_VERSION; // "major.minor.patch", a digit each

    switch (reg) {
    case DEVICE_MODEL: return DEVICE_MODEL_NUMBER;
    case DEVICE_VERSION: return (uint16_t)((version[0] - '0') << 4 | (version[2] - '0'));
    case DEVICE_FAILED: return device->failed;
    default: return device->ops->get(device->context, reg);
    }
}

/* Byte `index` of a register. */
static uint8_t byte_of(const struct device *device, uint8_t reg, uint16_t value, uint8_t index)
{
    if (reg == DEVICE_FAILED_IDS)
        return device->failed_ids[index];
    return (uint8_t)(index ? value >> 8 : value);
}

/* ---- READ ---- */

/* True if the register has a byte among the `count` bytes from address `from` on. */
static NOINLINE bool overlaps(uint8_t reg, uint8_t from, uint8_t count)
{
    uint8_t ahead = (uint8_t)(rows[reg].address - from);

    return ahead < count || (uint8_t)-ahead < rows[reg].bytes;
}

static uint8_t read(struct device *device, uint8_t *packet)
{
    uint8_t from = packet[CDS_AT_PARAMETERS], count = packet[CDS_AT_PARAMETERS + 1];

    if (packet[CDS_AT_LENGTH] != CDS_LENGTH_MIN + 2)
        return CDS_ERROR_INSTRUCTION;
    if (count == 0 || from >= DEVICE_TABLE_SIZE || count > DEVICE_TABLE_SIZE - from)
        return CDS_ERROR_RANGE;
    device->from = from;
    device->length = count;
    device->left = DEVICE_REGISTER_COUNT;
    memset(packet, 0, count); // addresses without a register read 0
    return 0;
}

static void put_register(const struct device *device, uint8_t *packet, uint8_t reg)
{
    uint16_t value = reg == DEVICE_FAILED_IDS ? 0 : value_of(device, reg);

    for (uint8_t i = 0; i < rows[reg].bytes; i++) {
        uint8_t at = (uint8_t)(rows[reg].address + i - device->from);

        if (at < device->length)
            packet[at] = byte_of(device, reg, value, i);
    }
}

/* Goes on with a READ; true when all its bytes are there. */
static bool read_on(struct device *device, uint8_t *packet)
{
    for (uint8_t looks = READ_PER_CALL; looks && device->left; looks--) {
        uint8_t reg = (uint8_t)(DEVICE_REGISTER_COUNT - device->left--);

        if (overlaps(reg, device->from, device->length))
            put_register(device, packet, reg);
    }
    return device->left == 0;
}

/* ---- WRITE and RESET ---- */

/* Returns how many of the written bytes are of this register; *value: its value after the WRITE. */
static uint8_t written(const struct device *device, const uint8_t *packet, uint8_t reg,
                       uint16_t *value)
{
    uint8_t from = packet[CDS_AT_PARAMETERS];
    uint8_t count = (uint8_t)(packet[CDS_AT_LENGTH] - CDS_LENGTH_MIN - 1);
    const uint8_t *data = &packet[CDS_AT_PARAMETERS + 1];
    uint8_t first = rows[reg].address, bytes = rows[reg].bytes, hits = 0;

    if (!overlaps(reg, from, count))
        return 0;
    if (rows[reg].access == RW)
        *value = value_of(device, reg);
    for (uint8_t i = 0; i < bytes; i++) {
        uint8_t address = (uint8_t)(first + i);

        if (address < from || address - from >= count)
            continue;
        hits++;
        if (i)
            *value = (uint16_t)((uint8_t)*value | (uint16_t)data[address - from] << 8);
        else
            *value = (uint16_t)((*value & 0xFF00u) | data[address - from]);
    }
    return hits;
}

static bool may_be(uint8_t reg, uint16_t value)
{
    return rows[reg].access == RW && value >= ranges[reg].lowest && value <= ranges[reg].highest;
}

static uint8_t write(struct device *device, const uint8_t *packet)
{
    const CDS_FLASH struct device_ops *ops = device->ops;
    uint8_t remaining = (uint8_t)(packet[CDS_AT_LENGTH] - CDS_LENGTH_MIN - 1);
    uint16_t value = 0;

    if (packet[CDS_AT_LENGTH] < CDS_LENGTH_MIN + 2)
        return CDS_ERROR_INSTRUCTION;
    for (uint8_t reg = 0; reg < DEVICE_REGISTER_COUNT; reg++) {
        uint8_t hits = written(device, packet, reg, &value);

        if (hits && (!may_be(reg, value) || !ops->allows(device->context, reg, value)))
            return CDS_ERROR_RANGE;
        remaining = (uint8_t)(remaining - hits);
    }
    if (remaining) // some addresses have no register
        return CDS_ERROR_RANGE;
    for (uint8_t reg = 0; reg < DEVICE_REGISTER_COUNT; reg++)
        if (written(device, packet, reg, &value))
            ops->set(device->context, reg, value);
    device->unsettled = true;
    return 0;
}

static uint8_t without_parameters(const uint8_t *packet)
{
    return packet[CDS_AT_LENGTH] == CDS_LENGTH_MIN ? 0 : CDS_ERROR_INSTRUCTION;
}

static uint8_t reset(struct device *device, const uint8_t *packet)
{
    uint8_t error = without_parameters(packet);

    if (error)
        return error;
    if (!device->ops->reset(device->context))
        return CDS_ERROR_RANGE;
    device->unsettled = true;
    return 0;
}

bool device_obey(struct device *device, uint8_t *packet)
{
    if (!device_is_busy(device)) {
        device->length = 0;
        switch (packet[CDS_AT_INSTRUCTION]) {
        case CDS_PING: device->error = without_parameters(packet); break;
        case CDS_READ: device->error = read(device, packet); break;
        case CDS_WRITE: device->error = write(device, packet); break;
        case CDS_RESET: device->error = reset(device, packet); break;
        default: device->error = CDS_ERROR_INSTRUCTION; break;
        }
    }
    if (device->unsettled)
        device->unsettled = !device->ops->settled(device->context);
    return !device->unsettled && read_on(device, packet);
}
