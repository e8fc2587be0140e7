#include "wire/uart.h"

uint32_t uart_bit_256(uint32_t clock_Hz, uint32_t baud)
{
    return (uint32_t)(((uint64_t)clock_Hz * 256 + baud / 2) / baud);
}

uint64_t uart_half_bits(uint32_t bit_256, unsigned half_bits)
{
    return ((uint64_t)bit_256 * half_bits + 256) / 512;
}

uint64_t talker_bit(const struct talker *talker, unsigned bit)
{
    return talker->start + uart_half_bits(talker->bit_256, bit * 2);
}

/* One event per change of level, not one per bit. */
static void talker_next(struct talker *talker)
{
    bool level = talker->frame >> talker->bit & 1;
    do {
        talker->bit++;
    } while (talker->bit < UART_FRAME_BITS && (talker->frame >> talker->bit & 1) == level);
    schedule_at(talker->schedule, &talker->event, talker_bit(talker, talker->bit));
}

static void talker_run(void *owner, uint64_t now)
{
    struct talker *talker = owner;
    if (talker->bit == UART_FRAME_BITS) {
        talker->busy = false;
        talker->on_end(talker->owner, now);
        return;
    }
    if (talker->bit == 0 && talker->on_start) {
        talker->on_start(talker->owner, now);
    }
    driver_level(talker->driver, now, talker->frame >> talker->bit & 1);
    talker_next(talker);
}

void talker_init(struct talker *talker, struct schedule *schedule, struct driver *driver,
                 void *owner)
{
    *talker = (struct talker){.schedule = schedule, .driver = driver, .owner = owner};
    event_init(&talker->event, talker_run, talker);
}

void talker_say(struct talker *talker, uint64_t start, uint32_t bit_256, uint8_t byte)
{
    talker->busy = true;
    talker->start = start;
    talker->bit_256 = bit_256;
    talker->driver->bit_256 = bit_256;
    talker->frame = (uint16_t)(0x200 | byte << 1);
    talker->bit = 0;
    schedule_at(talker->schedule, &talker->event, start);
}

uint64_t talker_end(const struct talker *talker)
{
    return talker_bit(talker, UART_FRAME_BITS);
}

void talker_stop(struct talker *talker, uint64_t now)
{
    schedule_cancel(talker->schedule, &talker->event);
    talker->busy = false;
    driver_level(talker->driver, now, true);
}

static uint64_t sample_time(const struct ear *ear, unsigned sample)
{
    return ear->start + uart_half_bits(ear->bit_256, sample * 2 + 1);
}

/* Takes all samples that lie before `time`; until then the net was at ear->level. */
static void catch_up(struct ear *ear, uint64_t time)
{
    while (ear->samples < UART_FRAME_BITS && sample_time(ear, ear->samples) < time) {
        ear->bits = (uint16_t)(ear->bits | ear->level << ear->samples);
        ear->samples++;
    }
}

static void begin(struct ear *ear, uint64_t time)
{
    if (ear->ask_bit) {
        ear->bit_256 = ear->ask_bit(ear->owner);
    }
    ear->hearing = true;
    ear->start = time;
    ear->samples = 0;
    ear->bits = 0;
    unsigned first = ear->on_start ? 0 : UART_FRAME_BITS - 1;
    schedule_at(ear->schedule, &ear->event, sample_time(ear, first));
}

static void ear_level(void *owner, uint64_t time, bool level)
{
    struct ear *ear = owner;
    if (ear->hearing) {
        catch_up(ear, time);
        /* High again in the middle of the start bit: it was a glitch, and this may be the start. */
        if (ear->samples && (ear->bits & 1)) {
            ear->hearing = false;
        }
    }
    /* High for no time at all, between two drivers: no falling edge. */
    if (!level && ear->enabled && !ear->hearing && ear->level_time != time) {
        begin(ear, time);
    }
    ear->level = level;
    ear->level_time = time;
}

static void ear_run(void *owner, uint64_t now)
{
    struct ear *ear = owner;
    catch_up(ear, now + 1);
    if (ear->bits & 1) {
        ear->hearing = false;
        return;
    }
    if (ear->samples < UART_FRAME_BITS) { // mid start bit: only with on_start
        schedule_at(ear->schedule, &ear->event, sample_time(ear, UART_FRAME_BITS - 1));
        ear->on_start(ear->owner, now);
        return;
    }
    /* When the stop bit is low the net must go high before a falling edge can start a frame: that
     * needs no care here, since only edges start one. */
    ear->hearing = false;
    struct heard heard = {
        .byte = (uint8_t)(ear->bits >> 1),
        .framing_error = !(ear->bits & 0x200),
        .start = ear->start,
        .end = ear->start + uart_half_bits(ear->bit_256, UART_FRAME_BITS * 2),
    };
    ear->on_byte(ear->owner, now, &heard);
}

void ear_init(struct ear *ear, struct schedule *schedule, struct net *net, void *owner)
{
    *ear = (struct ear){.schedule = schedule,
                        .net = net,
                        .owner = owner,
                        .level = net->level,
                        .level_time = SCHEDULE_NEVER};
    event_init(&ear->event, ear_run, ear);
    ear->event.rank = NET_SAMPLE_RANK;
    ear->listener = (struct listener){.owner = ear, .on_level = ear_level};
    net_listen(net, &ear->listener);
}

void ear_enable(struct ear *ear, bool enabled)
{
    if (!enabled) {
        schedule_cancel(ear->schedule, &ear->event);
        ear->hearing = false;
    }
    ear->enabled = enabled;
}
