/* SPDX-License-Identifier: MIT */
#include "output/plot.h"

#include <stdlib.h>
#include <string.h>

#include "memory.h"
#include "output/files.h"
#include "output/plot_drawing.h"

#define FIRST_BIN_US  5
#define FIRST_LOOK_US 1000

/* --- recording --- */

static struct plot_lane *lane_of(struct plot *plot, enum plot_sender sender, unsigned bus,
                                 unsigned id, unsigned duplicate)
{
    for (unsigned i = 0; i < plot->lanes; i++) {
        struct plot_lane *lane = plot->lane[i];
        if (lane->sender == sender && lane->bus == bus && lane->id == id &&
            lane->duplicate == duplicate) {
            return lane;
        }
    }
    struct plot_lane *lane = memory_checked(malloc(sizeof(*lane)));
    *lane = (struct plot_lane){.sender = sender, .bus = bus, .id = id, .duplicate = duplicate};
    memset(lane->sample, 0xFF, sizeof(lane->sample));
    plot->lane = memory_checked(realloc(plot->lane, (plot->lanes + 1) * sizeof(*plot->lane)));
    plot->lane[plot->lanes++] = lane;
    return lane;
}

static struct plot_lane *servo_lane(struct plot *plot, unsigned bus, const struct servo_node *node)
{
    unsigned duplicate = 0;
    for (const struct servo_node *n = node->servos->node; n < node; n++) {
        duplicate += n->id == node->id;
    }
    return lane_of(plot, PLOT_SERVO, bus, node->id, duplicate);
}

static void widen_bins(struct plot *plot)
{
    plot->bin *= 2;
    for (unsigned i = 0; i < plot->lanes; i++) {
        struct plot_lane *lane = plot->lane[i];
        for (unsigned b = 0; b < PLOT_BINS; b++) {
            bool lower = b < PLOT_BINS / 2;
            lane->busy[b] = lower ? lane->busy[2 * b] + lane->busy[2 * b + 1] : 0;
            for (unsigned m = 0; m < PLOT_MARKS; m++) {
                bool *mark = lane->mark[m];
                mark[b] = lower && (mark[2 * b] || mark[2 * b + 1]);
            }
        }
    }
}

static unsigned bin_of(struct plot *plot, uint64_t now)
{
    while (now / plot->bin >= PLOT_BINS) {
        widen_bins(plot);
    }
    return (unsigned)(now / plot->bin);
}

static void keep_packet(struct plot *plot, struct plot_lane *lane, uint64_t until)
{
    if (plot->packets == PLOT_PACKETS_MAX) {
        return;
    }
    struct plot_packet *last = lane->packets ? &lane->packet[lane->packets - 1] : 0;
    if (last && lane->since <= last->until + (until - lane->since)) {
        last->until = until; // one byte time or less after the packet: it belongs to the packet
        return;
    }
    if (lane->packets == lane->capacity) {
        lane->capacity = lane->capacity ? 2 * lane->capacity : 16;
        lane->packet =
            memory_checked(realloc(lane->packet, lane->capacity * sizeof(*lane->packet)));
    }
    lane->packet[lane->packets++] = (struct plot_packet){lane->since, until};
    plot->packets++;
}

static bool bus_is_busy(const struct plot *plot, unsigned bus)
{
    bool sends = false;
    for (unsigned i = 0; i < plot->lanes; i++) {
        sends = sends || (plot->lane[i]->bus == bus && plot->lane[i]->sending);
    }
    return sends;
}

static void set_sending(struct plot *plot, struct plot_lane *lane, uint64_t now, bool sends)
{
    if (lane->sending && !sends) {
        keep_packet(plot, lane, now);
        unsigned last = bin_of(plot, now);
        for (unsigned b = bin_of(plot, lane->since); b <= last; b++) {
            uint64_t from = b * plot->bin > lane->since ? b * plot->bin : lane->since;
            uint64_t until = (b + 1) * plot->bin < now ? (b + 1) * plot->bin : now;
            lane->busy[b] += until - from;
        }
    } else if (!lane->sending && sends) {
        lane->since = now;
        if (bus_is_busy(plot, lane->bus)) {
            plot_mark(plot, lane->bus, PLOT_COLLISION, now);
        }
    }
    lane->sending = sends;
}

void plot_controller(struct plot *plot, unsigned bus, uint64_t now, bool sends)
{
    if (plot->path) {
        set_sending(plot, lane_of(plot, PLOT_CONTROLLER, bus, 0, 0), now, sends);
    }
}

void plot_servo(struct plot *plot, unsigned bus, uint64_t now, const struct servo_node *node)
{
    if (plot->path) {
        set_sending(plot, servo_lane(plot, bus, node), now, node->driver.enabled);
    }
}

void plot_mark(struct plot *plot, unsigned bus, enum plot_mark mark, uint64_t now)
{
    if (plot->path) {
        unsigned bin = bin_of(plot, now);
        lane_of(plot, PLOT_WIRE, bus, 0, 0)->mark[mark][bin] = true;
    }
}

static void widen_samples(struct plot *plot)
{
    plot->period *= 2;
    plot->samples /= 2;
    for (unsigned i = 0; i < plot->lanes; i++) {
        struct plot_sample *sample = plot->lane[i]->sample;
        for (unsigned s = 0; s < PLOT_SAMPLES; s++) {
            sample[s] =
                s < PLOT_SAMPLES / 2 ? sample[2 * s] : (struct plot_sample){.goal = PLOT_ABSENT};
        }
    }
}

static void take_sample(struct plot *plot)
{
    for (unsigned bus = 0; bus < plot->buses; bus++) {
        const struct servos *servos = plot->set[bus];
        for (unsigned i = 0; i < servos->count; i++) {
            const struct servo *servo = &servos->node[i].servo;
            servo_lane(plot, bus, &servos->node[i])->sample[plot->samples] =
                (struct plot_sample){.goal = servo_goal_position(servo),
                                     .present = servo_present_position(servo),
                                     .speed = servo_present_speed(servo),
                                     .load = servo_present_load(servo)};
        }
    }
}

static void sample_event(void *context, uint64_t now)
{
    struct plot *plot = context;
    if (plot->samples == PLOT_SAMPLES - 1) { // the last sample is for the end of the run
        widen_samples(plot);
    }
    if (now >= plot->samples * plot->period) {
        take_sample(plot);
        plot->samples++;
    }
    schedule_at(plot->schedule, &plot->sample_event, plot->samples * plot->period);
}

void plot_bus(struct plot *plot, unsigned bus, const struct servos *servos)
{
    if (plot->path && bus < PLOT_SETS_MAX) {
        plot->set[bus] = servos;
        plot->buses = bus + 1;
        lane_of(plot, PLOT_WIRE, bus, 0, 0);
        lane_of(plot, PLOT_CONTROLLER, bus, 0, 0);
    }
}

/* --- start and end --- */

bool plot_open(struct plot *plot, const char *path, const char *title, const char *controller,
               struct plot_panes panes, struct schedule *schedule, uint32_t clock_Hz)
{
    char *arguments[] = {"gnuplot", "--version", 0};
    *plot = (struct plot){.path = path,
                          .title = title,
                          .panes = panes,
                          .schedule = schedule,
                          .clock_Hz = clock_Hz,
                          .controller = controller,
                          .bin = (uint64_t)clock_Hz * FIRST_BIN_US / 1000000u,
                          .period = (uint64_t)clock_Hz * FIRST_LOOK_US / 1000000u};
    data_path(plot->script, "scripts/plot.gp");
    FILE *file = files_create(path);
    if (!file) {
        return false;
    }
    fclose(file);
    if (plot_drawing_run_gnuplot(arguments, true) != 0) {
        fprintf(stderr, "%s: --plot needs gnuplot (Debian: gnuplot-nox), which does not run\n",
                path);
        return false;
    }
    event_init(&plot->sample_event, sample_event, plot);
    schedule_at(schedule, &plot->sample_event, 0);
    return true;
}

/* Sorts by bus; on each bus the wire, the controller, then the servos in their order. */
static void sort_lanes(struct plot *plot)
{
    for (unsigned i = 1; i < plot->lanes; i++) {
        struct plot_lane *lane = plot->lane[i];
        unsigned to = i;
        for (; to > 0; to--) {
            const struct plot_lane *above = plot->lane[to - 1];
            if (above->bus < lane->bus ||
                (above->bus == lane->bus && above->sender <= lane->sender)) {
                break;
            }
            plot->lane[to] = plot->lane[to - 1];
        }
        plot->lane[to] = lane;
    }
}

bool plot_draw(struct plot *plot, uint64_t end)
{
    if (!plot->path || !end) {
        return true;
    }
    for (unsigned i = 0; i < plot->lanes; i++) {
        set_sending(plot, plot->lane[i], end, false);
    }
    take_sample(plot);
    sort_lanes(plot);
    return plot_drawing_make(plot, end);
}

void plot_free(struct plot *plot)
{
    for (unsigned i = 0; i < plot->lanes; i++) {
        free(plot->lane[i]->packet);
        free(plot->lane[i]);
    }
    free(plot->lane);
    *plot = (struct plot){0};
}
