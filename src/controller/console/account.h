/* SPDX-License-Identifier: MIT */
/* The time since the reset, for `counters`. */
#ifndef CONTROLLER_ACCOUNT_H
#define CONTROLLER_ACCOUNT_H

/* Counts the seconds, for a profile with command_set.account: one in each call, so a late call is
 * made up for. The console calls it while no input waits. */
void account_tick(void);

#endif
