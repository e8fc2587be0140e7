/* SPDX-License-Identifier: MIT */
#include "output/trace.h"

#include <string.h>

#include "output/files.h"

/* --- signals --- */

static void sig_changed(void *context, uint64_t now, bool level)
{
    struct bus_trace *trace = context;
    vcd_change(trace->vcd, trace->sig, now, level);
}

static void txd_changed(void *context, uint64_t now, bool level)
{
    struct bus_trace *trace = context;
    vcd_change(trace->vcd, trace->txd, now, level);
}

static void rxd_changed(void *context, uint64_t now, bool level)
{
    struct bus_trace *trace = context;
    vcd_change(trace->vcd, trace->rxd, now, level);
}

static unsigned declare(struct bus_trace *trace, const char *name)
{
    char full[VCD_NAME_SIZE];
    snprintf(full, sizeof(full), "bus%u_%s", trace->bus, name);
    return vcd_signal(trace->vcd, full, 1);
}

void bus_trace_sig(struct bus_trace *trace, struct vcd *vcd, unsigned bus, struct net *sig)
{
    *trace = (struct bus_trace){.vcd = vcd, .bus = bus};
    if (!vcd->file) {
        return;
    }
    trace->sig = declare(trace, "wire");
    trace->controller = declare(trace, "controller_talks");
    trace->on_sig = (struct listener){trace, sig_changed, 0, 0};
    net_listen(sig, &trace->on_sig);
    sig_changed(trace, 0, sig->level);
}

void bus_trace_controller(struct bus_trace *trace, uint64_t now, bool sending)
{
    vcd_change(trace->vcd, trace->controller, now, sending);
    if (trace->plot) {
        plot_controller(trace->plot, trace->bus, now, sending);
    }
}

void bus_trace_init(struct bus_trace *trace, struct vcd *vcd, unsigned bus,
                    struct bus_circuit *circuit)
{
    bus_trace_sig(trace, vcd, bus, &circuit->sig);
    trace->circuit = circuit;
    if (!vcd->file) {
        return;
    }
    trace->tx_enable = declare(trace, "tx_enable");
    trace->rx_enable = declare(trace, "rx_enable");
    trace->txd = declare(trace, "txd");
    trace->rxd = declare(trace, "rxd");
    trace->on_txd = (struct listener){trace, txd_changed, 0, 0};
    trace->on_rxd = (struct listener){trace, rxd_changed, 0, 0};
    net_listen(&circuit->txd, &trace->on_txd);
    net_listen(&circuit->rxd, &trace->on_rxd);
    txd_changed(trace, 0, circuit->txd.level);
    rxd_changed(trace, 0, circuit->rxd.level);
    bus_trace_circuit(trace, 0);
}

void bus_trace_circuit(struct bus_trace *trace, uint64_t now)
{
    const struct bus_circuit *circuit = trace->circuit;
    vcd_change(trace->vcd, trace->tx_enable, now, circuit->tx_enable);
    vcd_change(trace->vcd, trace->rx_enable, now, circuit->rx_enable);
    bus_trace_controller(trace, now, circuit->usart.tx.busy);
}

static const struct servo_signals *signals(struct bus_trace *trace, unsigned id)
{
    struct servo_signals *s = &trace->servo[id];
    char name[32];
    if (!s->declared) {
        s->declared = true;
        snprintf(name, sizeof(name), "servo%u_talks", id);
        s->sending = declare(trace, name);
        snprintf(name, sizeof(name), "servo%u_torque", id);
        s->torque = declare(trace, name);
        snprintf(name, sizeof(name), "servo%u_led", id);
        s->led = declare(trace, name);
    }
    return s;
}

void bus_trace_servo(struct bus_trace *trace, uint64_t now, const struct servo_node *node)
{
    if (trace->vcd->file) {
        vcd_change(trace->vcd, signals(trace, node->id)->sending, now, node->driver.enabled);
    }
    if (trace->plot) {
        plot_servo(trace->plot, trace->bus, now, node);
    }
}

static void look_at_servos(void *context, uint64_t now)
{
    struct bus_trace *trace = context;
    for (unsigned i = 0; i < trace->servos->count; i++) {
        const struct servo_node *node = &trace->servos->node[i];
        const struct servo_signals *s = signals(trace, node->id);
        vcd_change(trace->vcd, s->torque, now, servo_torque(&node->servo));
        vcd_change(trace->vcd, s->led, now, servo_led(&node->servo));
    }
    schedule_at(trace->servos->schedule, &trace->look, now + trace->period);
}

void bus_trace_servos(struct bus_trace *trace, struct plot *plot, const struct servos *servos)
{
    trace->plot = plot;
    trace->servos = servos;
    trace->period = (uint64_t)servos->clock_Hz * SERVO_TICK_US / 1000000u;
    plot_bus(plot, trace->bus, servos);
    event_init(&trace->look, look_at_servos, trace);
    if (trace->vcd->file) {
        schedule_at(servos->schedule, &trace->look, trace->period);
    }
}

void bus_trace_new_servos(struct bus_trace *trace, uint64_t now)
{
    for (unsigned i = 0; i < trace->servos->count; i++) {
        bus_trace_servo(trace, now, &trace->servos->node[i]);
    }
}

/* --- motion --- */

static void write_row(void *context, uint64_t now)
{
    struct motion *motion = context;
    fprintf(motion->file, "%.3f", (double)now * 1000.0 / motion->clock_Hz);
    for (unsigned bus = 0; bus < motion->buses; bus++) {
        for (unsigned i = 0; i < motion->bus[bus]->count; i++) {
            const struct servo *servo = &motion->bus[bus]->node[i].servo;
            fprintf(motion->file, ",%u,%u", servo_goal_position(servo),
                    servo_present_position(servo));
        }
    }
    fputc('\n', motion->file);
    schedule_at(motion->schedule, &motion->sample, now + motion->clock_Hz / 1000 * 4);
}

static void write_head(const struct motion *motion)
{
    char prefix[16] = "";
    fputs(motion->blocks ? "\n\ntime_ms" : "time_ms", motion->file);
    for (unsigned bus = 0; bus < motion->buses; bus++) {
        if (motion->buses > 1) {
            snprintf(prefix, sizeof(prefix), "bus%u_", bus);
        }
        for (unsigned i = 0; i < motion->bus[bus]->count; i++) {
            unsigned id = motion->bus[bus]->node[i].id;
            fprintf(motion->file, ",%sgoal_%u,%spresent_%u", prefix, id, prefix, id);
        }
    }
    fputc('\n', motion->file);
}

bool motion_open(struct motion *motion, const char *path, struct schedule *schedule,
                 const struct servos *servos, uint32_t clock_Hz)
{
    *motion = (struct motion){.path = path, .schedule = schedule, .clock_Hz = clock_Hz};
    motion_bus(motion, servos);
    event_init(&motion->sample, write_row, motion);
    motion->file = files_create(path);
    return motion->file != 0;
}

void motion_bus(struct motion *motion, const struct servos *servos)
{
    if (motion->buses < BOARD_BUSES_MAX) {
        motion->bus[motion->buses++] = servos;
    }
}

bool motion_close(struct motion *motion)
{
    bool good = files_close(motion->file, motion->path);
    motion->file = 0;
    return good;
}

void motion_new_servos(struct motion *motion, uint64_t now)
{
    if (!motion->file) {
        return;
    }
    write_head(motion);
    motion->blocks++;
    write_row(motion, now);
}
