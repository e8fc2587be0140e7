/* SPDX-License-Identifier: MIT */
/* The pins of each USART, by chip, from the data sheets: tables "Alternate Functions" of the ports.
 * Other chips: RXD and TXD are not checked. */
#ifndef CDS_AVR_USART_PINS_H
#define CDS_AVR_USART_PINS_H

#include <avr/io.h>

/* The first USART: on port D, or on port E. */
#if defined __AVR_ATmega168__ || defined __AVR_ATmega168A__ || defined __AVR_ATmega168P__ ||       \
    defined __AVR_ATmega168PA__ || defined __AVR_ATmega328__ || defined __AVR_ATmega328P__ ||      \
    defined __AVR_ATmega164A__ || defined __AVR_ATmega164P__ || defined __AVR_ATmega164PA__ ||     \
    defined __AVR_ATmega324A__ || defined __AVR_ATmega324P__ || defined __AVR_ATmega324PA__ ||     \
    defined __AVR_ATmega644__ || defined __AVR_ATmega644A__ || defined __AVR_ATmega644P__ ||       \
    defined __AVR_ATmega644PA__ || defined __AVR_ATmega1284__ || defined __AVR_ATmega1284P__
#define CDS_AVR_USART_PINS_KNOWN 1
#define CDS_AVR_RXD0_PORT        D
#define CDS_AVR_RXD0_BIT         0
#define CDS_AVR_TXD0_PORT        D
#define CDS_AVR_TXD0_BIT         1
#elif defined __AVR_ATmega64__ || defined __AVR_ATmega64A__ || defined __AVR_ATmega128__ ||        \
    defined __AVR_ATmega128A__ || defined __AVR_AT90CAN64__ || defined __AVR_AT90CAN128__ ||       \
    defined __AVR_ATmega640__ || defined __AVR_ATmega1280__ || defined __AVR_ATmega1281__ ||       \
    defined __AVR_ATmega2560__ || defined __AVR_ATmega2561__
#define CDS_AVR_USART_PINS_KNOWN 1
#define CDS_AVR_RXD0_PORT        E
#define CDS_AVR_RXD0_BIT         0
#define CDS_AVR_TXD0_PORT        E
#define CDS_AVR_TXD0_BIT         1
#endif

/* The others are on the same pins of every chip above that has them. */
#define CDS_AVR_RXD1_PORT D
#define CDS_AVR_RXD1_BIT  2
#define CDS_AVR_TXD1_PORT D
#define CDS_AVR_TXD1_BIT  3
#define CDS_AVR_RXD2_PORT H
#define CDS_AVR_RXD2_BIT  0
#define CDS_AVR_TXD2_PORT H
#define CDS_AVR_TXD2_BIT  1
#define CDS_AVR_RXD3_PORT J
#define CDS_AVR_RXD3_BIT  0
#define CDS_AVR_TXD3_PORT J
#define CDS_AVR_TXD3_BIT  1

#endif
