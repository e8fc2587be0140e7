/* SPDX-License-Identifier: MIT */
/* Options of Unity: no floating point; on the AVR 16-bit int, and the output of unity_avr.c. */
#ifndef UNITY_CONFIG_H
#define UNITY_CONFIG_H

#define UNITY_EXCLUDE_FLOAT
#define UNITY_EXCLUDE_DOUBLE

#ifdef __AVR__
#define UNITY_INT_WIDTH         16
#define UNITY_LONG_WIDTH        32
#define UNITY_POINTER_WIDTH     16
#define UNITY_OUTPUT_CHAR(c)    unity_avr_put(c)
#define UNITY_OUTPUT_START()    unity_avr_open()
#define UNITY_OUTPUT_COMPLETE() unity_avr_end()
void unity_avr_open(void);
void unity_avr_put(int c);
void unity_avr_end(void);
#endif

#endif
