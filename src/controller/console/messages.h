/* What the console says, besides usage, findings and errors: one table, packed by scripts/texts.py;
 * TEXT_... of texts.h is where each is.
 *
 * Marks stand for the values of the printer, in their order: # decimal, $ a text, <long> two values
 * of 16 bits, low ones first, <deg> <rpm> <V> <C> <bps> a register's value and its unit. */
#ifndef CONTROLLER_SENTENCES_H
#define CONTROLLER_SENTENCES_H

#include "texts.h" // TEXT_...

/* X(name, text). In the order of an enum or of a struct: CONDITION_... of the CDS_ERROR_* bits,
 * ORIGIN_... of enum settings_origin, BUS_... and BUS_IS_... of enum cds_bus_state, RESET_... of
 * enum failsafe_reset, STOP_... of enum cds_torque_off_outcome, PRESENCE_... of enum cds_presence,
 * COUNTER_... of struct cds_stats. */
#define SENTENCES(X)                                                                               \
    X(NOTHING, "")                                                                                 \
    X(DECIMAL, "#")                                                                                \
    /* reply.c */                                                                                  \
    X(OK, "ok")                                                                                    \
    X(FAILED, "error #: $")                                                                        \
    X(FAILED_TOO, "also #: $")                                                                     \
    X(WARNING, "warning: $")                                                                       \
    X(CONDITION_VOLTAGE, "input voltage")                                                          \
    X(CONDITION_ANGLE, "angle limit")                                                              \
    X(CONDITION_OVERHEATING, "overheating")                                                        \
    X(CONDITION_RANGE, "range")                                                                    \
    X(CONDITION_CHECKSUM, "checksum")                                                              \
    X(CONDITION_OVERLOAD, "overload")                                                              \
    X(CONDITION_INSTRUCTION, "instruction")                                                        \
    /* cmd_help.c */                                                                               \
    X(LISTED, " $")                                                                                \
    X(EXAMPLE_IS, "Example: $")                                                                    \
    /* cmd_raw.c */                                                                                \
    X(ID, "id #")                                                                                  \
    /* cmd_servo.c */                                                                              \
    X(TORQUE_IS_OFF, "torque is off: it goes there once torque is on")                             \
    X(LIMITS_ARE_OFF, "angle limits set to 0: it turns without end")                               \
    /* cmd_register.c */                                                                           \
    X(IN_EEPROM, " EEPROM")                                                                        \
    X(IN_RAM, " RAM")                                                                              \
    /* cmd_setup.c */                                                                              \
    X(PLACE, "ID # at <bps>$")                                                                     \
    X(UNTIL_POWER_OFF, ", until power-off")                                                        \
    X(UNCHANGED_PLACE, "unchanged: ID # at <bps>")                                                 \
    X(UNCHANGED, "unchanged")                                                                      \
    X(WRITTEN, "written")                                                                          \
    /* cmd_monitor.c */                                                                            \
    X(LINES, "# lines, # answers missing")                                                         \
    /* cmd_group.c */                                                                              \
    X(GROUP, "group #")                                                                            \
    X(ONE_MORE, " #")                                                                              \
    X(BY_SYNC, " sync")                                                                            \
    X(BY_ACTION, " action")                                                                        \
    X(SERVO_FAILED, "servo #$: $")                                                                 \
    X(ARMED, ", may be armed still")                                                               \
    /* cmd_cycle.c */                                                                              \
    X(CYCLE_PERIODS, "periods <long>")                                                             \
    X(CYCLE_MISSED, ", missed <long>")                                                             \
    X(CYCLE_UNSENT, ", unsent <long>")                                                             \
    X(CYCLE_READS, "reads <long>")                                                                 \
    X(CYCLE_FAILED, ", failed <long>")                                                             \
    X(CYCLE_OLDEST, "oldest us <long>")                                                            \
    X(CYCLE_BUS, ", bus ")                                                                         \
    X(CYCLE_SERVO, "servo #: $")                                                                   \
    X(CYCLE_SERVO_KNOWN, "servo #: <deg> <rpm> <V> <C>$")                                          \
    X(HELD, " held")                                                                               \
    /* cmd_stop.c */                                                                               \
    X(STOP_UNKNOWN, "servo #: not looked at")                                                      \
    X(STOP_OFF, "")                                                                                \
    X(STOP_ON, "servo #: torque is on still")                                                      \
    X(STOP_SILENT, "servo #: no answer")                                                           \
    X(STOP_MUTE, "servo #: told, but set not to answer")                                           \
    X(STOP_STRANGERS, "up to # more servos were told and not looked at")                           \
    X(NOBODY, "none is known: scan finds them")                                                    \
    X(PRESENCE_UNKNOWN, "servo #: not asked yet, torque $")                                        \
    X(PRESENCE_HERE, "servo #: here, torque $")                                                    \
    X(PRESENCE_AWAY, "servo #: away, torque $")                                                    \
    X(PRESENCE_BACK, "servo #: back, being looked at, torque $")                                   \
    X(OFF, "off")                                                                                  \
    X(ON, "on")                                                                                    \
    X(HELD_LOST, ", held: lost its state, torque went off")                                        \
    X(HELD_STOPPED, ", held: stopped")                                                             \
    X(ALARMS, ", alarms: $")                                                                       \
    X(ALARMS_MORE, " + $")                                                                         \
    /* cmd_bus.c */                                                                                \
    X(FOUND, "id #$$$")                                                                            \
    X(FOUND_MODEL, " model #")                                                                     \
    X(FOUND_RATE, " at <bps>")                                                                     \
    X(FOUND_DAMAGED, ": damaged, two of one ID?")                                                  \
    X(FOUND_NEIGHBOUR, ", a neighbour")                                                            \
    X(FOUND_TOO_MANY, ": too many to know")                                                        \
    X(ASKED, "# of # asked, now at <bps>")                                                         \
    X(FOUND_IN_ALL, "# found, # asked")                                                            \
    X(COUNTER_SENT, "sent #")                                                                      \
    X(COUNTER_REPEATED, "repeated #")                                                              \
    X(COUNTER_OK, "ok #")                                                                          \
    X(COUNTER_TIMEOUTS, "timeouts #")                                                              \
    X(COUNTER_CORRUPT, "corrupt #")                                                                \
    X(COUNTER_UNSENT, "unsent #")                                                                  \
    X(COUNTER_REFUTED, "refuted #")                                                                \
    X(COUNTER_STRAY, "stray #")                                                                    \
    X(COUNTER_LATE, "late #")                                                                      \
    X(COUNTER_EXTRA, "extra #")                                                                    \
    X(COUNTER_FOREIGN, "foreign #")                                                                \
    X(COUNTER_FRAMING, "framing errors #")                                                         \
    X(COUNTER_OVERRUNS, "overruns #")                                                              \
    X(COUNTER_OVERFLOWS, "ring overflows #")                                                       \
    X(COUNTER_ECHO, "echo errors #")                                                               \
    X(BUS_IS_OK, "bus ok at <bps>")                                                                \
    X(BUS_IS_BUSY, "bus busy: others use it at <bps>")                                             \
    X(BUS_IS_LOW, "bus held low at <bps>")                                                         \
    /* cmd_diagnose.c */                                                                           \
    X(FINDING_IS, "finding #: $")                                                                  \
    X(TALLY, "asked #, answered #, damaged #, silent #")                                           \
    X(WAITS, ", waits us #")                                                                       \
    X(SUPPLY, ", supply mV #")                                                                     \
    X(HOT, ", hot C #")                                                                            \
    /* cmd_keeper.c */                                                                             \
    X(ORIGIN_NONE, "settings at start: defaults: nothing was ever saved")                          \
    X(ORIGIN_DAMAGED, "settings at start: defaults: what was saved is damaged")                    \
    X(ORIGIN_OTHER, "settings at start: defaults: what was saved is of another version")           \
    X(ORIGIN_OLDER, "settings at start: as saved by an older firmware; new ones are defaults")     \
    X(ORIGIN_NEWER, "settings at start: as saved by a newer firmware")                             \
    X(ORIGIN_STORED, "settings at start: as saved")                                                \
    X(ORIGIN_CORRECTED,                                                                            \
      "settings at start: as saved, but one was out of range and is its default")                  \
    X(ALARM, "alarm $: $")                                                                         \
    X(OF_OTHERS, "of others")                                                                      \
    X(RESET, "reset by$$$$$")                                                                      \
    X(RESET_POWER, " power")                                                                       \
    X(RESET_EXTERNAL, " external")                                                                 \
    X(RESET_BROWN_OUT, " brown-out")                                                               \
    X(RESET_WATCHDOG, " watchdog")                                                                 \
    X(RESET_JTAG, " JTAG")                                                                         \
    X(HOST_RESCUED, "host link at own rate of the board: save keeps it")                           \
    X(LINK_OFF, "host link: not watched")                                                          \
    X(LINK_ON, "host link: watched")                                                               \
    X(LINK_LOST, "host link: lost")                                                                \
    X(TORQUE_NEVER, "last stop: none")                                                             \
    X(TORQUE_PENDING, "last stop: under way")                                                      \
    X(TORQUE_READ, "last stop: # of # servos read back as off$")                                   \
    X(TORQUE_SOME_ON, "last stop: # of # servos read back as off, some are on$")                   \
    X(STRANGERS, "; up to # more were not looked at")                                              \
    X(INHIBIT_OFF, "driving: allowed")                                                             \
    X(INHIBIT_ON, "driving: inhibited until 'release'")                                            \
    X(INHIBIT_LINK, "driving: inhibited until 'clear'")                                            \
    X(STOPS, "Ctrl-X in damaged packets: #")                                                       \
    X(DELAYS, "RETURN_DELAY refused: #; this board bears # or more")                               \
    X(BUS_OK, "bus: ok")                                                                           \
    X(BUS_BUSY, "bus: busy")                                                                       \
    X(BUS_FAULT, "bus: fault")                                                                     \
    X(SERVOS, "servos: #$, held #, away #")                                                        \
    X(AND_MORE, " and more")                                                                       \
    X(STACK, "stack: # of # bytes never used")

#endif
