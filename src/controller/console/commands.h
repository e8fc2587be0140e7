/* The table of the console's commands: help, docs/console.md and the tests come from it. A row's
 * begin and poll are in the file named beside them; see struct command. */
#ifndef CONTROLLER_COMMANDS_H
#define CONTROLLER_COMMANDS_H

#include "console/command.h"

/* X(name, group, takes, instruction or 0, begin, poll, arguments, what it does, details, example)
 * The order within a group is that of the list. */
#define COMMANDS(X)                                                                                \
    /* cmd_help.c */                                                                               \
    X(help, CONSOLE, "?c", 0, NULL, help_poll, " [COMMAND]", "this list, or one command",          \
      "COMMAND: a name out of the list", "help move")                                              \
    X(version, CONSOLE, "", 0, NULL, version_poll, "", "version and board", "Of this firmware.",   \
      "version")                                                                                   \
    X(echo, CONSOLE, "(on|off)", 0, echo_begin, NULL, " on|off", "show what is typed, or not",     \
      "Scripts read replies more easily without.", "echo off")                                     \
    /* cmd_servo.c */                                                                              \
    X(move, SERVO, "bu?u", 0, move_begin, move_poll, " ID ANGLE [SPEED]", "go to an angle",        \
      "ANGLE: 0 to 300deg, or 0raw to 1023raw. SPEED: 0 to 62rpm, 0 as fast as it can; without "   \
      "it the servo's speed stays as it is. ID 254: all",                                          \
      "move 1 90deg 30rpm")                                                                        \
    X(turn, SERVO, "iu", 0, turn_begin, turn_poll, " ID SPEED", "turn without end",                \
      "SPEED: -62 to 62rpm, positive CCW, 0 stands still. Sets both angle limits to 0, for "       \
      "which the servo must not be locked; 'set ID CCW_ANGLE_LIMIT 300' ends it",                  \
      "turn 1 -20rpm")                                                                             \
    X(torque, SERVO, "b(on|off)", 0, torque_begin, exchange_poll, " ID on|off",                    \
      "torque on or off", "With torque off the output turns freely. ID 254: all", "torque 1 on")   \
    X(led, SERVO, "b(on|off)", 0, led_begin, exchange_poll, " ID on|off", "LED on or off",         \
      "ID 254: all", "led 1 on")                                                                   \
    /* cmd_register.c */                                                                           \
    X(get, SERVO, "ir", 0, get_begin, get_poll, " ID NAME", "a register, with its unit",           \
      "NAME as in docs/registers.md and info, or an address. In brackets: as the register has it", \
      "get 1 PRESENT_VOLTAGE")                                                                     \
    X(set, SERVO, "iru", 0, set_begin, set_poll, " ID NAME VALUE[unit]", "set a register",         \
      "VALUE in the unit that get shows, or another of its kind (deg mdeg, rpm mrpm, V mV, us ms " \
      "s, bps kbps), or raw. What outlives power-off is written only if it differs, and read "     \
      "back. ID and BAUD_RATE: by id and baud",                                                    \
      "set 1 MIN_VOLTAGE 6.5V")                                                                    \
    X(info, SERVO, "i", 0, info_begin, info_poll, " ID", "all registers of a servo",               \
      "Address, name, value with unit, the same as the register has it, area", "info 1")           \
    /* cmd_monitor.c */                                                                            \
    X(monitor, SERVO, "l?(every)u", 0, monitor_begin, monitor_poll, " ID... [every MS]",           \
      "draw what servos do, until a key",                                                          \
      "Up to 8 servos; MS: 10 to 60000ms, 100 if left out. A line a period, for serial plotters",  \
      "monitor 1 2 every 50ms")                                                                    \
    /* cmd_group.c */                                                                              \
    X(group, MANY, "?l?(sync|action)", 0, group_begin, group_poll, " [ID... [sync|action]]",       \
      "choose the servos of pose and cycle, or show them",                                         \
      "sync: all are told in one SYNC WRITE, unanswered. action: each is asked first (REG WRITE) " \
      "and all start with one ACTION, or none does. sync if left out",                             \
      "group 1 2 3 action")                                                                        \
    X(pose, MANY, "p?(at)u", 0, pose_begin, pose_poll, " ANGLE... [at SPEED]",                     \
      "move the group, all at once",                                                               \
      "An angle for each servo of the group, in its order, 0 to 300deg; SPEED: 0 to 62rpm, 0 as "  \
      "fast as it can, 20rpm if left out. While a cycle runs, it takes the goals over",            \
      "pose 90 150.5 210 at 20rpm")                                                                \
    X(cycle, MANY, "?(every|off)?u", 0, cycle_begin, cycle_poll, " [every [MS]|off]",              \
      "exchange goals and feedback at a fixed rate, or show how it goes",                          \
      "Of the group; MS: 2 to 65ms, else cycle_us of the settings. Goals are where the servos "    \
      "are, until pose gives others",                                                              \
      "cycle every 4ms")                                                                           \
    /* cmd_stop.c */                                                                               \
    X(stop, CARE, "", 0, stop_begin, stop_poll, "", "torque off everywhere, at once",              \
      "Ctrl-X does it anywhere, ahead of everything. Nothing drives until release", "stop")        \
    X(release, CARE, "?i", 0, release_begin, NULL, " [ID]", "let servos be driven again",          \
      "All after stop; ID: one that lost its state. Nothing moves: torque and goal are set anew",  \
      "release")                                                                                   \
    X(limits, CARE, "iuu?u", 0, limits_begin, NULL, " ID LOW HIGH [SPEED]",                        \
      "how far and how fast a servo may be driven",                                                \
      "Angles, 0 to 300deg, and a speed, up to 62rpm. What goes beyond is not sent, by whomever. " \
      "Until power-off, for one of the robot's servos; 'limits ID 0 300' takes them away",         \
      "limits 1 60 240 30rpm")                                                                     \
    X(servos, CARE, "?(forget)", 0, servos_begin, servos_poll, " [forget]",                        \
      "the servos of the robot, and how they are", "scan finds them. forget: empties the list",    \
      "servos")                                                                                    \
    /* cmd_setup.c */                                                                              \
    X(id, SETUP, "ij", 0, id_begin, identity_poll, " OLD NEW", "give a servo another ID",          \
      "0 to 253. Looks first whether NEW is free, and afterwards where the servo is", "id 1 5")    \
    X(baud, SETUP, "iu", 0, baud_begin, identity_poll, " ID RATE", "another rate for a servo",     \
      "RATE: 7843 to 2000000bps, or the register, 0raw to 254raw. The bus goes along; 'bus' "      \
      "takes it back",                                                                             \
      "baud 1 57600bps")                                                                           \
    X(factory, SETUP, "b?(force)", 0, factory_begin, identity_poll, " ID [force]",                 \
      "factory values: ID 1 at 1 Mbps afterwards",                                                 \
      "254, all servos, only with force: they have one ID then, and none can be spoken to alone",  \
      "factory 1")                                                                                 \
    X(lock, SETUP, "i", 0, lock_begin, setup_poll, " ID", "no set-up until power-off",             \
      "Only registers 0x18 to 0x23 can be written until then", "lock 1")                           \
    /* cmd_bus.c */                                                                                \
    X(scan, BUS, "?(all|rescue)", 0, scan_begin, scan_poll, " [all|rescue]", "who is there?",      \
      "At the bus's rate; whom it finds joins the robot's servos. all: at the six listed rates, "  \
      "3.5 s. rescue: at all 255, nine minutes. Ends with a key",                                  \
      "scan")                                                                                      \
    X(diagnose, BUS, "?b", 0, diagnose_begin, diagnose_poll, " [ID]", "why does it not answer?",   \
      "Tells silence, echo, noise, wrong rate, collision, two of one ID, low supply apart. "       \
      "No ID: of whoever is there. Ends with a key",                                               \
      "diagnose 1")                                                                                \
    X(counters, BUS, "?i", 0, counters_begin, counters_poll, " [ID]",                              \
      "what was sent, answered, lost",                                                             \
      "Since power-up, modulo 65536; of the bus, or of one of the robot's servos: late, extra, "   \
      "foreign and echo errors up to 255",                                                         \
      "counters")                                                                                  \
    X(bus, BUS, "?u", 0, bus_begin, bus_poll, " [RATE]", "rate of the bus",                        \
      "RATE: 7843 to 2000000bps, or the register, 0raw to 254raw; none: shows it",                 \
      "bus 1000000bps")                                                                            \
    /* cmd_raw.c */                                                                                \
    X(ping, RAW, "b", CDS_PING, raw_begin, ping_poll, " ID", "is it there? (254: who is there?)",  \
      "254 finds one that is alone on the bus", "ping 1")                                          \
    X(read, RAW, "ir?n", CDS_READ, raw_begin, read_poll, " ID REG [LENGTH]",                       \
      "read a register, or LENGTH bytes from it on",                                               \
      "REG: name or address, 0 to 0x31. LENGTH: 1 to 50", "read 1 PRESENT_POSITION")               \
    X(write, RAW, "brv", CDS_WRITE, raw_begin, exchange_poll, " ID REG VALUE...",                  \
      "write a register and those that follow it",                                                 \
      "By name: values of registers. By address: bytes, 0 to 255. ID 254: all",                    \
      "write 1 GOAL_POSITION 512 300")                                                             \
    X(regwrite, RAW, "brv", CDS_REG_WRITE, raw_begin, exchange_poll, " ID REG VALUE...",           \
      "the same, kept by the servo until action", "As write", "regwrite 2 GOAL_POSITION 700")      \
    X(action, RAW, "?b", CDS_ACTION, raw_begin, exchange_poll, " [ID]",                            \
      "carry out what was kept (no ID: all servos)", "All start at the same moment", "action")     \
    X(reset, RAW, "i", CDS_RESET, raw_begin, exchange_poll, " ID",                                 \
      "factory values: it is ID 1 at 1 Mbps afterwards",                                           \
      "factory does the same and looks whether it worked", "reset 1")                              \
    X(sync, RAW, "rns", CDS_SYNC_WRITE, raw_begin, exchange_poll,                                  \
      " REG LENGTH ID:BYTE,BYTE,... ...", "write many servos at once",                             \
      "LENGTH: bytes for each servo, 1 to 50. Not answered",                                       \
      "sync GOAL_POSITION 4 1:0,2,44,1 2:0,1,44,1")                                                \
    /* cmd_keeper.c */                                                                             \
    X(status, KEEPER, "", 0, NULL, status_poll, "", "how the controller is",                       \
      "Reset, settings, host link, inhibit, torque off, bus, servos, stack", "status")             \
    X(alarms, KEEPER, "", 0, NULL, alarms_poll, "", "alarms of servos since clear",                \
      "Whatever a reply said, whoever asked. Told at once if alarm_report is set", "alarms")       \
    X(clear, KEEPER, "", 0, clear_begin, NULL, "", "alarms and a lost host link are seen to",      \
      "Servos held for that or by stop may be driven again; nothing moves", "clear")               \
    X(settings, KEEPER, "?k?u", 0, settings_begin, settings_poll, " [NAME [VALUE]]",               \
      "the controller's settings, or one of them",                                                 \
      "As in docs/settings.md. A value counts at once, and until power-off unless saved",          \
      "settings link_loss_ms 500")                                                                 \
    X(save, KEEPER, "", 0, save_begin, save_poll, "", "keep the settings without power",           \
      "In the EEPROM; 0.2 s, beside the bus", "save")                                              \
    X(defaults, KEEPER, "", 0, defaults_begin, settings_poll, "",                                  \
      "settings as in a new controller", "Kept only by save", "defaults")

/* COMMAND_help, ...: the rows. */
enum command_kind {
#define COMMAND_ENUM_(name, group, takes, instruction, begin, poll, arguments, what, details,      \
                      example)                                                                     \
    COMMAND_##name,
    COMMANDS(COMMAND_ENUM_)
#undef COMMAND_ENUM_
        COMMAND_COUNT,
} __attribute__((packed));

extern const CDS_FLASH struct command commands[COMMAND_COUNT];

#endif
