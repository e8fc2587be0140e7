/* SPDX-License-Identifier: MIT */
/* What a chip must supply for the core: the verbs of a port, found at link time.
 * The events it raises in return are in link.h. avr.h is the port for AVRs;
 * test/support/port_fake.c records.
 *
 * `port` is the number of a bus of the board, from 0: what was given to cds_bus_open(). Circuit and
 * meaning of the two enables: manual 1.2.3. The two are never both on.
 */
#ifndef CDS_PORT_H
#define CDS_PORT_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Sets the line rate: 2 000 000 / (baud + 1) bit/s, `baud` 0 to 254 as in register 0x04. Leaves the
 * port in high impedance. Main context, interrupts on or off. */
void cds_port_open(uint8_t port, uint8_t baud);

/* Receiver and driver off, no events. Either context. */
void cds_port_high_z(uint8_t port);

/* Driver off, then receiver on; on_rx from here on. Either context. */
void cds_port_listen(uint8_t port);

/* Sets the port to high impedance, then switches driver and transmitter on and gives `byte` to the
 * transmitter. If the transmitter can take a second byte at once, it gets `byte` again. Returns how
 * many bytes the transmitter has taken, 1 or 2. No events until cds_port_follow(). Main context. */
uint8_t cds_port_talk(uint8_t port, uint8_t byte);

/* Events from here on: on_tx_ready as soon as another byte can be taken. Main context; only behind
 * cds_port_talk(). */
void cds_port_follow(uint8_t port);

/* Gives the transmitter the next byte. Only within on_tx_ready. */
void cds_port_tx(uint8_t port, uint8_t byte);

/* Gives the transmitter the last byte, then forgets any older "complete", then asks for
 * on_tx_complete and for no further on_tx_ready: in this order, and all of it within less than a
 * byte time, or a stale flag would release the driver too early. Only within on_tx_ready. */
void cds_port_tx_last(uint8_t port, uint8_t byte);

/* Is the line high, as far as the receiver can tell, at this very moment? An idle line is; low is a
 * start or data bit of 0, or a line that is held low. Only while listening. Main context. */
bool cds_port_line_is_high(uint8_t port);

/* Microseconds, free running, wrapping at 2^32 (71.6 min). Main context. */
uint32_t cds_port_now_us(void);

/* Returns the same in ticks of half a microsecond, modulo 2^16 (32.8 ms), cheaper. Main context. */
#define CDS_PORT_TICKS_PER_US 2
uint16_t cds_port_ticks(void);

/* Sets the timer of the port to the moment `from` (as of cds_port_ticks()) plus `count` x `each_us`
 * plus `more_us`: 0 to 2^20 - 1 us after `from`. The timer wraps every 32.8 ms and expires
 * once in each wrap. Returns how many expiries come before the last one, 0 to 31; the caller
 * answers each with cds_port_restart_timer(). The last one never comes early. It comes late by the
 * time that an earlier one waited for that call, and if the timer is set more than 32 ms after
 * `from`. Main context. */
uint8_t cds_port_set_timer(uint8_t port, uint16_t from, uint16_t count, uint16_t each_us,
                           uint16_t more_us);

/* Returns true from an expiry on. For every poll. Main context. */
bool cds_port_timer_expired(uint8_t port);

/* The timer counts as not expired until its next expiry. Main context. */
void cds_port_restart_timer(uint8_t port);

#ifdef __cplusplus
}
#endif

#endif
