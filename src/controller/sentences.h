/* Lines that the console says as they stand: one table, packed by scripts/texts.py. */
#ifndef CONTROLLER_SENTENCES_H
#define CONTROLLER_SENTENCES_H

#include <stdint.h>

#include "flash.h" // CDS_FLASH

/* X(name, text). ORIGIN_... in the order of enum settings_origin, BUS_... of enum cds_bus_state. */
#define SENTENCES(X)                                                                               \
    X(ORIGIN_NONE, "settings at start: defaults: nothing was ever saved")                          \
    X(ORIGIN_DAMAGED, "settings at start: defaults: what was saved is damaged")                    \
    X(ORIGIN_OTHER, "settings at start: defaults: what was saved is of another version")           \
    X(ORIGIN_STORED, "settings at start: as saved")                                                \
    X(ORIGIN_CORRECTED,                                                                            \
      "settings at start: as saved, but one was out of range and is its default")                  \
    X(LINK_OFF, "host link: not watched")                                                          \
    X(LINK_ON, "host link: watched")                                                               \
    X(LINK_LOST, "host link: lost")                                                                \
    X(STOP_NEVER, "torque off: not asked for")                                                     \
    X(STOP_PENDING, "torque off: under way")                                                       \
    X(STOP_ALL, "torque off: all")                                                                 \
    X(STOP_SOME_ON, "torque off: not all: some are on")                                            \
    X(STOP_UNKNOWN, "torque off: not known of all")                                                \
    X(BUS_OK, "bus: ok")                                                                           \
    X(BUS_BUSY, "bus: busy")                                                                       \
    X(BUS_FAULT, "bus: fault")                                                                     \
    X(NOBODY, "none is known: scan finds them")                                                    \
    X(TORQUE_IS_OFF, "torque is off: it goes there once torque is on")                             \
    X(LIMITS_ARE_OFF, "angle limits set to 0: it turns without end")

enum sentence {
#define SENTENCE_ENUM_(name, text) SENTENCE_##name,
    SENTENCES(SENTENCE_ENUM_)
#undef SENTENCE_ENUM_
        SENTENCE_COUNT,
};

extern const CDS_FLASH char *const CDS_FLASH sentences[SENTENCE_COUNT];

#endif
