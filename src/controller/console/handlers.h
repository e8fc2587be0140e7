/* What the rows of commands.h begin and poll; see struct command. */
#ifndef CONTROLLER_HANDLERS_H
#define CONTROLLER_HANDLERS_H

#include <stdbool.h>
#include <stdint.h>

struct console;

/* cmd_help.c */
bool help_poll(struct console *console);
bool version_poll(struct console *console);
uint8_t echo_begin(struct console *console);

/* cmd_raw.c */
uint8_t raw_begin(struct console *console);
bool exchange_poll(struct console *console); // of any command that submitted console->line.request
bool ping_poll(struct console *console);
bool read_poll(struct console *console);

/* cmd_servo.c */
uint8_t move_begin(struct console *console);
bool move_poll(struct console *console);
uint8_t turn_begin(struct console *console);
bool turn_poll(struct console *console);
uint8_t torque_begin(struct console *console);
uint8_t led_begin(struct console *console);
/* READ and WRITE of line.id: enum cds_result. What is written is console->job.set.data. */
uint8_t servo_read(struct console *console, uint8_t address, uint8_t length);
uint8_t servo_write(struct console *console, uint8_t address, uint8_t length);

/* cmd_register.c */
uint8_t get_begin(struct console *console);
bool get_poll(struct console *console);
uint8_t set_begin(struct console *console);
bool set_poll(struct console *console);
uint8_t info_begin(struct console *console);
bool info_poll(struct console *console);

/* cmd_monitor.c */
uint8_t monitor_begin(struct console *console);
bool monitor_poll(struct console *console);

/* cmd_group.c */
uint8_t group_begin(struct console *console);
bool group_poll(struct console *console);
uint8_t pose_begin(struct console *console);
bool pose_poll(struct console *console);

/* cmd_cycle.c */
uint8_t cycle_begin(struct console *console);
bool cycle_poll(struct console *console);

/* cmd_stop.c */
uint8_t stop_begin(struct console *console);
bool stop_poll(struct console *console);
uint8_t release_begin(struct console *console);
uint8_t limits_begin(struct console *console);
uint8_t servos_begin(struct console *console);
bool servos_poll(struct console *console);

/* cmd_setup.c */
uint8_t id_begin(struct console *console);
uint8_t baud_begin(struct console *console);
uint8_t factory_begin(struct console *console);
bool identity_poll(struct console *console);
uint8_t lock_begin(struct console *console);
/* Begins a setup in console->job that writes there to line.id: enum cds_result. */
uint8_t setup_write(struct console *console, uint8_t address, const uint8_t *data, uint8_t length);
bool setup_waits(struct console *console); // console_waits() of a setup in console->job
bool setup_poll(struct console *console);  // of any command with a setup in console->job

/* cmd_bus.c */
uint8_t scan_begin(struct console *console);
bool scan_poll(struct console *console);
uint8_t counters_begin(struct console *console);
bool counters_poll(struct console *console);
uint8_t bus_begin(struct console *console);
bool bus_poll(struct console *console);

/* cmd_diagnose.c */
uint8_t diagnose_begin(struct console *console);
bool diagnose_poll(struct console *console);

/* cmd_keeper.c */
bool status_poll(struct console *console);
bool alarms_poll(struct console *console);
uint8_t clear_begin(struct console *console);
uint8_t settings_begin(struct console *console);
bool settings_poll(struct console *console);
uint8_t save_begin(struct console *console);
bool save_poll(struct console *console);
uint8_t defaults_begin(struct console *console);

/* Between two lines: tells of an alarm unasked, if that is set. False: there is nothing of it left
 * to say, and a line may begin. */
bool alarm_tell(struct console *console);

#endif
