/* SPDX-License-Identifier: MIT */
/* The control table against the manual's, byte by byte. */
#include "cds55xx/control_table.h"

#include <string.h>

#include "unity.h"

static const uint8_t reserved[] = {0x00, 0x0A, 0x13, 0x2D};
static const uint8_t words[] = {0x06, 0x08, 0x0E, 0x14, 0x16, 0x1E, 0x20, 0x24, 0x26, 0x28, 0x30};
static const uint8_t read_only[] = {0x01, 0x02, 0x14, 0x16, 0x24, 0x26, 0x28, 0x2A, 0x2B, 0x2E};

/* Manual 3.1, the column of initial values with R11, R12, R26 and R38; each byte on its own. */
static const uint8_t initial[CDS_TABLE_SIZE] = {
    0, 1,  1,  1,   1,    1,    0, 0,    0xFF, 0x03, // 0x00
    0, 80, 60, 160, 0xFF, 0x03, 2, 0x25, 0x04, 0,    // 0x0A
    0, 0,  0,  0,   0,    0,    2, 2,    32,   32,   // 0x14
    0, 0,  0,  0,   32,   32,   0, 0,    0,    0,    // 0x1E
    0, 0,  0,  0,   0,    0,    0, 0,    0x5A, 0,    // 0x28
};

static struct cds_register at(uint8_t address)
{
    struct cds_register found;

    TEST_ASSERT_TRUE(cds_register_at(address, &found));
    return found;
}

static bool named(const char *name, struct cds_register *found)
{
    return cds_register_named(name, (uint8_t)strlen(name), found);
}

static void assert_named(uint8_t address, const char *name)
{
    struct cds_register found = {.address = 0xEE};

    TEST_ASSERT_TRUE(named(name, &found));
    TEST_ASSERT_EQUAL_HEX8(address, found.address);
}

static bool is_in(uint8_t address, const uint8_t *list, uint8_t count)
{
    return memchr(list, address, count) != NULL;
}

void setUp(void)
{
}

void tearDown(void)
{
}

void test_every_byte_belongs_to_exactly_one_register(void)
{
    uint8_t address = 0;
    uint8_t registers = 0;

    while (address < CDS_TABLE_SIZE) {
        struct cds_register first = at(address);

        TEST_ASSERT_EQUAL_HEX8(address, first.address); // no gap, no overlap
        for (uint8_t i = 0; i < first.width; i++)
            TEST_ASSERT_EQUAL_HEX8(address, at((uint8_t)(address + i)).address);
        address = (uint8_t)(address + first.width);
        registers++;
    }
    TEST_ASSERT_EQUAL_HEX8(0x32, address);
    TEST_ASSERT_EQUAL_UINT8(50 - sizeof words, registers);
}

void test_no_register_past_the_table(void)
{
    struct cds_register untouched = {.address = 0xEE, .width = 0xEE};

    for (uint16_t address = CDS_TABLE_SIZE; address < 256; address++) {
        TEST_ASSERT_FALSE(cds_register_at((uint8_t)address, &untouched));
        TEST_ASSERT_EQUAL_HEX8(0xEE, untouched.address);
        TEST_ASSERT_EQUAL_HEX8(0xEE, untouched.width);
    }
}

void test_words_are_those_of_the_manual(void)
{
    for (uint8_t address = 0; address < CDS_TABLE_SIZE; address++) {
        struct cds_register here = at(address);

        TEST_ASSERT_EQUAL_UINT8(is_in(here.address, words, sizeof words) ? 2 : 1, here.width);
    }
}

void test_high_byte_of_a_word_leads_to_the_word(void)
{
    for (uint8_t i = 0; i < sizeof words; i++)
        TEST_ASSERT_EQUAL_HEX8(words[i], at((uint8_t)(words[i] + 1)).address);
}

void test_access_is_that_of_the_manual(void)
{
    for (uint8_t address = 0; address < CDS_TABLE_SIZE; address++) {
        struct cds_register here = at(address);
        uint8_t wanted = CDS_ACCESS_RW;

        if (is_in(here.address, read_only, sizeof read_only))
            wanted = CDS_ACCESS_RD;
        else if (is_in(here.address, reserved, sizeof reserved) && here.address != 0x13) // R5
            wanted = CDS_ACCESS_NO;
        TEST_ASSERT_EQUAL(wanted, here.access);
    }
}

void test_eeprom_ends_where_ram_begins(void)
{
    for (uint8_t address = 0; address < CDS_TABLE_SIZE; address++)
        TEST_ASSERT_EQUAL(address < 0x18 ? CDS_AREA_EEPROM : CDS_AREA_RAM, at(address).area);
    TEST_ASSERT_EQUAL_HEX8(0x18, CDS_EEPROM_SIZE);
}

void test_initial_values_are_those_of_the_manual(void)
{
    for (uint8_t address = 0; address < CDS_TABLE_SIZE; address++) {
        struct cds_register here = at(address);
        uint16_t value = initial[here.address];

        if (here.width == 2)
            value = (uint16_t)(value + 256u * initial[here.address + 1]);
        TEST_ASSERT_EQUAL_HEX16(value, here.initial);
    }
}

/* The same by sums of known values, the factory's of the EEPROM area and those at power-up. */
void test_initial_values_add_up(void)
{
    uint16_t eeprom = 0, ram = 0;

    for (uint8_t address = 0; address < CDS_TABLE_SIZE; address++) {
        struct cds_register here = at(address);

        if (here.address != address)
            continue; // a high byte: its word has been counted
        if (here.area == CDS_AREA_EEPROM)
            eeprom = (uint16_t)(eeprom + here.initial);
        else
            ram = (uint16_t)(ram + here.initial);
    }
    // 5 ones, two limits of 1023, 80 + 60 + 160, level 2, 0x25 + 0x04
    TEST_ASSERT_EQUAL_UINT16(5 + 2 * 1023 + 300 + 2 + 41, eeprom);
    TEST_ASSERT_EQUAL_UINT16(2 * 2 + 4 * 32 + 90, ram); // margins, proportions, slopes, punch
}

void test_initial_values_lie_within_their_ranges(void)
{
    for (uint8_t address = 0; address < CDS_TABLE_SIZE; address++) {
        struct cds_register here = at(address);

        TEST_ASSERT_TRUE(here.lowest <= here.initial && here.initial <= here.highest);
        TEST_ASSERT_TRUE(here.width == 2 || here.highest <= 0xFF);
    }
}

/* R33, by its own sentences. */
static uint16_t highest_of(uint8_t address)
{
    switch (address) {
    case 0x03: return 253;
    case 0x04:
    case 0x05: return 254;
    case 0x06:
    case 0x08:
    case 0x0E:
    case 0x1E:
    case 0x30: return 0x3FF;
    case 0x20: return 0x7FF;
    case 0x10: return 2;
    case 0x11:
    case 0x12: return 0x7F;
    case 0x18:
    case 0x19:
    case 0x2C:
    case 0x2F: return 1;
    default: return 255;
    }
}

void test_ranges_of_writable_registers(void)
{
    for (uint8_t address = 0; address < CDS_TABLE_SIZE; address++) {
        struct cds_register here = at(address);

        if (here.access != CDS_ACCESS_RW)
            continue;
        TEST_ASSERT_EQUAL_UINT16(0, here.lowest);
        TEST_ASSERT_EQUAL_UINT16(highest_of(here.address), here.highest);
    }
}

/* What can be read there: positions of ten bits, speed and load with a direction above them (R35).
 */
void test_ranges_of_what_can_only_be_read(void)
{
    TEST_ASSERT_EQUAL_HEX16(0x3FF, at(CDS_REG_PRESENT_POSITION).highest);
    TEST_ASSERT_EQUAL_HEX16(0x7FF, at(CDS_REG_PRESENT_SPEED).highest);
    TEST_ASSERT_EQUAL_HEX16(0x7FF, at(CDS_REG_PRESENT_LOAD).highest);
    TEST_ASSERT_EQUAL_HEX16(0xFFFF, at(CDS_REG_UP_CALIBRATION).highest);
    TEST_ASSERT_EQUAL_HEX16(0xFFFF, at(CDS_REG_DOWN_CALIBRATION).highest);
    TEST_ASSERT_EQUAL_HEX16(1, at(CDS_REG_MOVING).highest);
}

void test_names_lead_to_their_registers(void)
{
    assert_named(0x01, "MODEL_NUMBER");
    assert_named(0x02, "FIRMWARE_VERSION");
    assert_named(0x03, "ID");
    assert_named(0x04, "BAUD_RATE");
    assert_named(0x05, "RETURN_DELAY");
    assert_named(0x06, "CW_ANGLE_LIMIT");
    assert_named(0x08, "CCW_ANGLE_LIMIT");
    assert_named(0x0E, "MAX_TORQUE");
    assert_named(0x10, "STATUS_RETURN_LEVEL");
    assert_named(0x18, "TORQUE_ENABLE");
    assert_named(0x19, "LED");
    assert_named(0x1E, "GOAL_POSITION");
    assert_named(0x20, "MOVING_SPEED");
    assert_named(0x22, "ACC");
    assert_named(0x24, "PRESENT_POSITION");
    assert_named(0x2B, "PRESENT_TEMPERATURE");
    assert_named(0x2C, "REGISTERED_INSTRUCTION");
    assert_named(0x2E, "MOVING");
    assert_named(0x2F, "LOCK");
    assert_named(0x30, "PUNCH");
    assert_named(0x00, "RESERVED_00");
    assert_named(0x13, "RESERVED_13");
    assert_named(0x2D, "RESERVED_2D");
}

void test_addresses_have_the_names_of_the_manual(void)
{
    TEST_ASSERT_EQUAL_HEX8(0x0B, CDS_REG_MAX_TEMPERATURE);
    TEST_ASSERT_EQUAL_HEX8(0x0C, CDS_REG_MIN_VOLTAGE);
    TEST_ASSERT_EQUAL_HEX8(0x0D, CDS_REG_MAX_VOLTAGE);
    TEST_ASSERT_EQUAL_HEX8(0x11, CDS_REG_ALARM_LED);
    TEST_ASSERT_EQUAL_HEX8(0x12, CDS_REG_ALARM_SHUTDOWN);
    TEST_ASSERT_EQUAL_HEX8(0x14, CDS_REG_DOWN_CALIBRATION);
    TEST_ASSERT_EQUAL_HEX8(0x16, CDS_REG_UP_CALIBRATION);
    TEST_ASSERT_EQUAL_HEX8(0x1A, CDS_REG_CW_COMPLIANCE_MARGIN);
    TEST_ASSERT_EQUAL_HEX8(0x1B, CDS_REG_CCW_COMPLIANCE_MARGIN);
    TEST_ASSERT_EQUAL_HEX8(0x1C, CDS_REG_CW_PROPORTION);
    TEST_ASSERT_EQUAL_HEX8(0x1D, CDS_REG_CCW_PROPORTION);
    TEST_ASSERT_EQUAL_HEX8(0x23, CDS_REG_DCC);
    TEST_ASSERT_EQUAL_HEX8(0x26, CDS_REG_PRESENT_SPEED);
    TEST_ASSERT_EQUAL_HEX8(0x28, CDS_REG_PRESENT_LOAD);
    TEST_ASSERT_EQUAL_HEX8(0x2A, CDS_REG_PRESENT_VOLTAGE);
}

void test_every_name_leads_back_to_its_address(void)
{
    char name[CDS_REGISTER_NAME_SIZE];

    for (uint8_t address = 0; address < CDS_TABLE_SIZE; address++) {
        uint8_t length = cds_register_name(address, name, sizeof name);

        TEST_ASSERT_TRUE(length > 0);
        TEST_ASSERT_EQUAL_UINT8(strlen(name), length);
        assert_named(at(address).address, name);
    }
}

void test_case_and_dashes_do_not_matter(void)
{
    assert_named(0x1E, "goal_position");
    assert_named(0x1E, "goal-position");
    assert_named(0x1E, "Goal-Position");
    assert_named(0x1B, "ccw-Compliance_MARGIN");
    assert_named(0x0A, "reserved-0a");
}

void test_unknown_names_are_not_found(void)
{
    static const char *const unknown[] = {
        "",    "I",    "IDS",    "GOAL", "GOAL_POSITIO", "GOAL_POSITIONS", "GOAL POSITION",
        "_",   "PUNC", "PUNCH_", "QUUX", "RESERVED_",    "\x7F",           "ID_",
        " ID", "0x1E",
    };
    struct cds_register untouched = {.address = 0xEE};

    for (uint8_t i = 0; i < sizeof unknown / sizeof unknown[0]; i++)
        TEST_ASSERT_FALSE(named(unknown[i], &untouched));
    TEST_ASSERT_EQUAL_HEX8(0xEE, untouched.address);
}

void test_only_length_characters_of_a_name_count(void)
{
    struct cds_register found = {.address = 0xEE};

    TEST_ASSERT_TRUE(cds_register_named("LED on", 3, &found)); // a word of a longer line
    TEST_ASSERT_EQUAL_HEX8(0x19, found.address);
    TEST_ASSERT_FALSE(cds_register_named("LED on", 4, &found));
    TEST_ASSERT_FALSE(cds_register_named("LED on", 2, &found));
}

/* A NUL among the characters is a character, and no name has it: all names stand in one string. */
void test_name_with_a_nul_inside_is_not_found(void)
{
    static const char two[] = "ID\0BAUD_RATE", last[] = "PUNCH\0\0";
    struct cds_register untouched = {.address = 0xEE};

    TEST_ASSERT_FALSE(cds_register_named(two, sizeof two - 1, &untouched));
    TEST_ASSERT_FALSE(cds_register_named(two, 3, &untouched));
    TEST_ASSERT_FALSE(cds_register_named(last, sizeof last - 1, &untouched));
}

void test_name_is_cut_to_the_room_it_has(void)
{
    char name[8];

    memset(name, '#', sizeof name);
    TEST_ASSERT_EQUAL_UINT8(4, cds_register_name(CDS_REG_GOAL_POSITION, name, 5));
    TEST_ASSERT_EQUAL_STRING("GOAL", name);
    TEST_ASSERT_EQUAL('#', name[5]);
    TEST_ASSERT_EQUAL_UINT8(0, cds_register_name(CDS_REG_GOAL_POSITION, name, 1));
    TEST_ASSERT_EQUAL_STRING("", name);
    name[0] = '#';
    TEST_ASSERT_EQUAL_UINT8(0, cds_register_name(CDS_REG_GOAL_POSITION, name, 0));
    TEST_ASSERT_EQUAL('#', name[0]);
}

void test_name_size_is_the_longest_and_no_more(void)
{
    char name[40];
    uint8_t longest = 0;

    for (uint8_t address = 0; address < CDS_TABLE_SIZE; address++) {
        uint8_t length = cds_register_name(address, name, sizeof name);

        if (length > longest)
            longest = length;
    }
    TEST_ASSERT_EQUAL_UINT8(CDS_REGISTER_NAME_SIZE - 1, longest);
}

void test_no_name_past_the_table(void)
{
    char name[CDS_REGISTER_NAME_SIZE] = "left over";

    TEST_ASSERT_EQUAL_UINT8(0, cds_register_name(CDS_TABLE_SIZE, name, sizeof name));
    TEST_ASSERT_EQUAL_STRING("", name);
}
