/* SPDX-License-Identifier: MIT */
/* A command of the console. It is a row of a table in flash, in the file with the code that carries
 * it out (commands/). A profile (profiles/) names the groups of rows that its firmware links. Of
 * all commands the console itself knows one, the monitor: Ctrl-X ends its table. */
#ifndef CONTROLLER_COMMAND_H
#define CONTROLLER_COMMAND_H

#include <stdbool.h>
#include <stdint.h>

#include "compiler.h"         // ALWAYS_INLINE
#include "console/messages.h" // FLASH_TEXT()
#include "flash.h"            // CDS_FLASH

/* `details` or `example` of a row. The profile `console` leaves them to docs/console.md: there the
 * struct is empty, which saves 4 bytes in each row of the table. */
#ifdef COMMANDS_WITHOUT_DETAILS
struct command_details {
};
#define COMMAND_DETAILS(string)                                                                    \
    {                                                                                              \
    }
#define COMMAND_DETAILS_TEXT(of) NULL
#else
struct command_details {
    const CDS_FLASH char *text;
};
#define COMMAND_DETAILS(string)                                                                    \
    {                                                                                              \
        FLASH_TEXT(string)                                                                         \
    }
#define COMMAND_DETAILS_TEXT(of) ((of).text)
#endif

struct account;
struct noise;
struct command_line;
struct command_typing;
struct console;
struct device_ops;
struct failsafe;
struct history;
struct moves;
struct motion_outcome;
struct motion_store;
struct robot_operation;
struct settings_store;
struct token;
struct unasked;
struct ended_motion;

/* What a command does: the functions of struct command. */
struct command_action {
    uint8_t (*begin)(struct console *console);
    bool (*poll)(struct console *console);
};

struct command {
    /* The name and the arguments. The parser checks a line against this text, and help and
     * docs/console.md print it. Rules:
     *   - [ ] encloses an argument that may be missing, and with it all arguments after it
     *   - a|b in small letters: one of these words
     *   - rows may begin alike: the first word that differs chooses the row. Rows with a small word
     *     there stand before the row with a NAME
     *   - a word in capitals is an argument, stored in `struct command_line`:
     *
     *   in the usage   argument                        stored in
     *   ID             0 to 253, or a list             id; 254 if it is missing
     *   ID|254         0 to 254, or a list             id; 254 if it is missing
     *   OLD            0 to 253                        id
     *   NEW            0 to 253                        new_id
     *   REG            name or address of a register   address, length
     *   LENGTH         1 to the end of the table       length
     *   COMMAND        name of a command               topic
     *   SETTING        name of a setting               setting
     *   NAME, POSE     a name of the user              parse_name()
     *   VALUE...       values of registers             the packet
     *   ID:BYTE,...    blocks of a SYNC WRITE          the packet
     *   ID...          a list of 0 to 253              list, a byte each
     *   ANGLE...       angles                          list, a word each, low byte first
     *   other words    a number, unit optional         number[0], then [1], then [2]
     *
     * A profile with lists of servos (servo_list.h) runs the command once for each servo of a list
     * in the place of an ID, unless the line itself is a packet. */
    const CDS_FLASH char *usage;
    const CDS_FLASH char *what;     // what the command does
    struct command_details details; // ranges and remarks
    struct command_details example; // a line to type; none: it is the usage
    /* Starts the command. Returns 0, or the error that ends the command at once: an enum cds_result
     * or a number of CONSOLE_ERRORS (errors.h). NULL: there is nothing to start. */
    uint8_t (*begin)(struct console *console);
    /* Moves the command on. The main loop calls it whenever the printer is ready, until it returns
     * false. It never waits. console->step counts the calls from 0 on, up to 255. It stores an
     * error in console->error. NULL: the reply ends right after begin. Never NULL for a command
     * that sends a packet: console_waits(), or a function that calls it. */
    bool (*poll)(struct console *console);
    uint8_t instruction; // the line itself is a packet with this instruction; 0: it is not
};

struct command_group {
    const CDS_FLASH char *heading; // in the list of help; NULL: no heading
    const CDS_FLASH struct command *rows;
    uint8_t count;
};

/* Poses and sequences in the EEPROM. */
struct command_store {
    struct motion_store *motions;
    /* main() calls it once, before the host link is open: finds the records, takes up to 40 ms. */
    void (*load)(struct motion_store *motions, const struct settings_store *settings);
    void (*abort)(struct motion_store *motions); // Ctrl-X has ended a command
    void (*end)(struct console *console);        // a line was refused, or its command has ended
    void (*room)(struct console *console);       // prints a line of `status`
    void (*wear)(struct console *console);       // prints the line of `status` behind it
    /* main() calls it once, after the load and failsafe_begin(): begins what plays without a host.
     * NULL: this firmware has no motions. */
    void (*begin)(const struct failsafe *failsafe, struct motion_store *motions);
};

/* Lists of servos in a line: servo_list.h. */
struct command_lists {
    /* The parser's: take the first word of a list, in the place of an ID from 0 to `highest`, and
     * any word of a list. Return an error or 0. */
    uint8_t (*take)(struct command_line *line, const struct token *token, uint8_t highest);
    uint8_t (*take_word)(struct command_line *line, const struct token *token);
    /* The parser's, while line->list_is_open: true if this word belongs to the list; and what is
     * called at the end of the line. Both may store line->error. */
    bool (*goes_on)(struct command_line *line, const struct token *token);
    void (*end)(struct command_line *line);
    /* The console's: begin and poll of the command, for each servo of the list. */
    uint8_t (*begin)(struct console *console);
    bool (*poll)(struct console *console);
};

/* More words about a motion that has failed, with the pose: motion_words.c. */
struct command_motion_words {
    /* Keeps how the last motion has ended, once, in command_set.ended_motion. Called in each turn
     * while the console waits for input, and before the end is printed. */
    void (*keep_end)(struct console *console);
    /* As motion_print_cause() (shared.h): prints a line. */
    void (*cause)(struct console *console, const struct motion_outcome *outcome);
    /* Prints "in step 3, pose far: ", at most 27 characters; nothing if there is no step. */
    void (*step)(struct console *console, const struct motion_outcome *outcome);
    /* Prints the end of a line: why the autostart has not begun, or that its motion has ended.
     * False: it has no more words. */
    bool (*autostart)(struct console *console);
    /* The poll of `settings autostart`. */
    bool (*show_autostart)(struct console *console);
    /* The text of an error whose remedy depends on the motion, as advice(); NULL: the text of the
     * error itself is the best. */
    const CDS_FLASH char *(*advise)(struct console *console);
    /* Prints a line if a user, a stop or a lost link has ended the last motion. */
    void (*end)(struct console *console);
    /* The end of the line of a sequence that plays: its speed, in printer->values[4]. */
    const CDS_FLASH char *(*limit)(struct console *console);
    /* Call before each start of `play`. Marks the steps found too fast so far; the check then goes
     * past them. */
    void (*begin)(struct console *console);
    /* Call after each start of a motion. Returns true if `play` must start again to find the next
     * step that is too fast; it has printed this one. Returns false at the end; console->error is
     * ERROR_TOO_FAST if a step was too fast. */
    bool (*tries_again)(struct console *console);
    /* Prints a warning after a motion has begun: a servo reports its input voltage. */
    void (*warn)(struct console *console);
    /* True if stored poses have servos. */
    bool (*has_poses)(void);
    /* True if a stored pose has the servo. */
    bool (*uses_servo)(uint8_t id);
    /* For the part `index` of a line: prints ID `index` of these servos, behind the last one the
     * end of the line. False: the line has ended. */
    bool (*group)(struct console *console, uint8_t index);
    /* Chooses the servos of the stored poses as the group if there is none. Returns an error or 0.
     */
    uint8_t (*choose)(struct console *console);
};

/* What a profile links: commands, the storage of motions, and the registers of the device. */
struct command_set {
    const CDS_FLASH struct command_group *const CDS_FLASH *groups; // ends with NULL
    /* Groups that this firmware has only to name them: each row ends with ERROR_OMITTED. Ends with
     * NULL; NULL: there are none. */
    const CDS_FLASH struct command_group *const CDS_FLASH *named_only;
    const CDS_FLASH struct command *on_stop;       // runs after a Ctrl-X
    const CDS_FLASH char *const CDS_FLASH *errors; // messages by number (errors.h)
    /* Called between two lines. Prints reports that no command asked for. Returns false if there is
     * nothing to print. */
    bool (*report)(struct console *console);
    const CDS_FLASH struct robot_operation *cycle;  // of the group: group_cycle or motion_cycle
    const CDS_FLASH struct command_action *pose_in; // "pose ... in TIME"
    const CDS_FLASH struct device_ops *device;      // device_registers_ops or motion_registers_ops
    struct moves *moves;                            // storage of timed moves, or NULL
    const CDS_FLASH struct command_store *store;    // NULL: the profile stores nothing
    const CDS_FLASH struct command_lists *lists;    // NULL: an ID is one servo
    const CDS_FLASH struct command_action *baud_list; // "baud" with a list of servos, or NULL
    /* Converts number 0 of the line to a value of setting line.setting, in console->raw. Returns an
     * error or 0. NULL: every setting is a plain number. */
    uint8_t (*setting_number)(struct console *console);
    bool (*after_scan)(struct console *console); // end of the poll of `scan`, or NULL
    struct account *account;                     // of the counters, or NULL
    bool (*explain)(struct console *console);    // explain.h; NULL: errors have their text only
    /* Texts of advice.h. NULL: this firmware has no room for them. */
    const CDS_FLASH char *(*advise)(struct console *console);     // advice()
    const CDS_FLASH char *(*note)(struct console *console);       // advice_note()
    const CDS_FLASH char *(*link_lost)(struct console *console);  // advice_link_lost()
    const CDS_FLASH char *(*more_slips)(struct console *console); // more_slips.h
    void (*words)(struct console *console);                       // advice_words()
    void (*after_reset)(struct console *console);                 // advice_after_reset()
    const CDS_FLASH char *(*bus_changed)(struct console *console,
                                         uint8_t old);         // advice_bus_changed()
    void (*monitor)(struct console *console, uint8_t value);   // monitor.h; NULL: lines only
    const CDS_FLASH struct command_typing *typing;             // completion and hints, or NULL
    struct history *history;                                   // storage of line_editor.c, or NULL
    const CDS_FLASH struct command_motion_words *motion_words; // NULL: words without the pose
    /* Chips with 256 KB of flash: longer texts, and READs before and after writes. */
    bool has_room;
    struct noise *noise;               // noise.h; NULL: noise is not looked for
    struct ended_motion *ended_motion; // shared.h; for a profile with motion_words, else NULL
    struct unasked *unasked; // unasked.h; NULL: no room to tell more than faults and alarms
    uint8_t set_up_tries;    // how often id, baud, factory, lock, set and restore try; 0 is as 1
};

extern const CDS_FLASH struct command_set command_set;

/* True if this firmware only names the commands of the group. ALWAYS_INLINE: saves 40 bytes in a
 * firmware that has all commands it names. */
ALWAYS_INLINE bool command_is_only_named(const CDS_FLASH struct command_group *group)
{
    const CDS_FLASH struct command_group *const CDS_FLASH *named = command_set.named_only;

    for (; named && *named; named++)
        if (*named == group)
            return true;
    return false;
}

#endif
