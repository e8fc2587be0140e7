/* SPDX-License-Identifier: MIT */
/* Completion by Tab, and hints at unknown names. */
#include "typing_rig.h"

void setUp(void)
{
    begin_console();
    settings.echo = 1;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

void test_tab_completes_a_unique_name_with_a_space(void)
{
    static const char *const cases[][2] = {
        {"torque ", "tor\t"},
        {"torque ", "torque\t"},
        {"torque ", "TOR\t"},
        {"torque 1 off ", "torque 1 of\t"},
        {"help torque ", "help tor\t"},
        {"get 1 PRESENT_LOAD ", "get 1 PRESENT_L\t"},
        {"get 1 PRESENT_LOAD ", "get 1 present_L\t"},
        {"settings link_loss_ms ", "settings link_loss_m\t"},
        {"write  1  LED ", "write  1  LED\t"},
        {"torque all ", "torque a\t"},
        {"group all ", "group AL\t"},
        {"release all ", "release a\t"},
        {"help safety ", "help saf\t"},
        {"help set-up ", "help set-\t"},
        {"help motion ", "help mot\t"}, // command and heading
        {"help without ", "help wi\t"},
        {"help all ", "help all\t"},
        {"help units ", "help un\t"},
        {"limits 1 off ", "limits 1 o\t"},
    };

    for (uint8_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        assert_line(cases[i][0], cases[i][1]);
}

void test_tab_lists_a_word_of_several_rows_once(void)
{
    static const char list[] = "sequence walk \r\nnew  add  show  set  insert  delete  \r\n";

    TEST_ASSERT_EQUAL_STRING_LEN(list, typed("sequence walk \t"), sizeof list - 1);
}

void test_tab_on_a_long_line_stays_within_the_editor(void)
{
    char keys[EDITOR_SIZE + 1];

    for (uint8_t length = EDITOR_SIZE - 16; length < EDITOR_SIZE; length++) {
        memset(keys, ' ', sizeof keys);
        memcpy(keys, "get 1", 5);
        memcpy(keys + length - 4, "REGI", 4); // REGISTERED_INSTRUCTION and a space: 19 more
        keys[length] = '\0';
        typed(keys);
        TEST_ASSERT_EQUAL_STRING("\a", typed_more("\t"));
        TEST_ASSERT_EQUAL_UINT8(length, console.editor.length);
    }
    assert_line("get 1 LED", "get 1 LED");
}

void test_tab_completes_all_only_where_a_list_stands_and_is_begun(void)
{
    assert_line("torque ", "torque \t");
    assert_line("ping a", "ping a\t");
    assert_line("id a", "id a\t");
    assert_line("move 1 a", "move 1 a\t");
}

void test_tab_completes_what_several_names_share(void)
{
    assert_line("torque 1 o", "torque 1 \t");
    assert_line("settings link_loss_", "settings l\t");
    assert_line("get 1 PRESENT_", "get 1 PRE\t");
    assert_line("get 1 PRESENT_", "get 1 pre\t");
}

void test_tab_completes_before_the_cursor(void)
{
    assert_line("torque 1 on", "tor 1 on\x1B[H\x1B[C\x1B[C\x1B[C\t\b");
}

void test_tab_lists_names_and_shows_the_line_again(void)
{
    TEST_ASSERT_EQUAL_STRING("torque 1 o\r\non  off  \r\ntorque 1 o", typed("torque 1 o\t"));
    TEST_ASSERT_EQUAL_STRING("settings link_loss_\r\nlink_loss_ms  link_loss_action  \r\n"
                             "settings link_loss_",
                             typed("settings link_loss_\t"));
    reply_to(""); // and the line is whole
    TEST_ASSERT_NOT_NULL(strstr(said, "error 60: SETTING 'link_loss_': unknown setting"));
}

void test_tab_on_an_empty_line_lists_each_command_once(void)
{
    const char *first;

    typed("\t");
    first = strstr(said, "torque  ");
    TEST_ASSERT_NOT_NULL(first);
    TEST_ASSERT_NULL(strstr(first + 1, "torque  "));
    first = strstr(said, "pose  "); // it has several rows
    TEST_ASSERT_NOT_NULL(first);
    TEST_ASSERT_NULL(strstr(first + 1, " pose  "));
    TEST_ASSERT_NOT_NULL(strstr(said, "diagnose  "));
    assert_line("", "\t");
}

void test_tab_rings_if_nothing_fits(void)
{
    TEST_ASSERT_EQUAL_STRING("frob\a", typed("frob\t"));
    TEST_ASSERT_EQUAL_STRING("ping x 1\a", typed("ping x 1\t"));
    TEST_ASSERT_EQUAL_STRING("move 1 9\a", typed("move 1 9\t"));
    assert_line("move 1 9", "move 1 9\t");
}

void test_tab_of_a_program_separates_words(void)
{
    settings.echo = 0;
    reply_to("ping\t1");
    assert_sent("FF FF 01 02 01 FB");
}

void test_tab_in_a_long_line_does_nothing(void)
{
    for (uint8_t i = 0; i < 100; i++)
        type_part(" ");
    type("tor\t");
    TEST_ASSERT_EQUAL_STRING_LEN("tor", console.editor.text + console.editor.length - 3, 3);
}

void test_ctrl_w_in_a_line_longer_than_the_editor_deletes_words(void)
{
    char id[] = "100 ";

    type("group ");
    for (uint8_t i = 0; i < 20; i++, id[2]++) { // 86 characters: the parser has the first words
        id[1] = (char)(id[2] > '9' ? id[1] + 1 : id[1]);
        id[2] = (char)(id[2] > '9' ? '0' : id[2]);
        type(id);
    }
    for (uint8_t i = 0; i < 20; i++)
        type("\x17");
    TEST_ASSERT_EQUAL_UINT8(0, console.editor.length);
    said_length = 0;
    type("200\r");
    TEST_ASSERT_EQUAL_STRING("200\r\ngroup 100 101 102 103 104 105 106 107 200 sync\r\nok\r\n",
                             said);
}

void test_ctrl_x_ends_completion_and_drops_the_line(void)
{
    type_part("t\t");
    type("\x18");
    TEST_ASSERT_EQUAL_UINT8(0, console.editor.length);
    TEST_ASSERT_FALSE(console.completing);
}

void test_line_after_completion_is_carried_out(void)
{
    typed("pin\t1");
    said_length = 0;
    type("\r");
    port_fake_transmit(&bus.link, 0);
    assert_sent("FF FF 01 02 01 FB");
}

/* ---- hints ---- */

static void assert_hint(const char *name, const char *line)
{
    char hint[60] = "; did you mean ";

    settings.echo = 0;
    reply_to(line);
    TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE("error ", said, 6, line);
    TEST_ASSERT_EQUAL_STRING("\r\n", said + strlen(said) - 2);
    if (name)
        strcat(strcat(hint, name), "?\r\n");
    if (name)
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(said, hint), said);
    else
        TEST_ASSERT_NULL_MESSAGE(strstr(said, hint), said);
}

void test_unknown_name_hints_at_the_nearest_one(void)
{
    static const char *const cases[][2] = {
        {"torque", "tourqe 1 on"},
        {"torque", "toruqe 1 on"},
        {"torque", "TORQU 1 on"},
        {"ping", "pong 1"},
        {"ping", "pinng 1"},
        {"ping", "pnig 1"},
        {"off", "torque 1 ofg"},
        {"off", "torque 1 of"}, // `on` has one error, too
        {"scan", "help scam"},
        {"GOAL_POSITION", "write 1 GOAL_POSITON 512"},
        {"GOAL_POSITION", "write 1 goal_position_ 512 and more words"},
        {"link_loss_ms", "settings linkloss_ms 5"},
        {"monitor", "mon 1"},
        {"monitor", "monotor 1"},
        {"GOAL_POSITION", "get 1 GOAL"},
    };

    for (uint8_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        assert_hint(cases[i][0], cases[i][1]);
}

void test_unknown_name_far_from_all_has_no_hint(void)
{
    assert_hint(NULL, "xyzzy");
    assert_hint(NULL, "x");
    assert_hint(NULL, "averyveryveryverylongwordindeed");
    assert_hint(NULL, "get 1 AIM");
    assert_hint(NULL, "ping one");
    assert_hint(NULL, "torque 1 o"); // on and off begin so
}
