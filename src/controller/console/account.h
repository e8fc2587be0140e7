/* The time since the reset, for `counters`. */
#ifndef CONTROLLER_ACCOUNT_H
#define CONTROLLER_ACCOUNT_H

/* Counts the seconds, if the profile has command_set.account. The console calls it at least once a
 * second. */
void account_tick(void);

#endif
