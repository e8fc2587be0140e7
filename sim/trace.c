#include "trace.h"

#include <errno.h>
#include <string.h>

/* --- signals -------------------------------------------------------------------------------------
 */

static void sig_changed(void *owner, uint64_t now, bool level)
{
    struct bus_trace *trace = owner;
    vcd_change(trace->vcd, trace->sig, now, level);
}

static void txd_changed(void *owner, uint64_t now, bool level)
{
    struct bus_trace *trace = owner;
    vcd_change(trace->vcd, trace->txd, now, level);
}

static void rxd_changed(void *owner, uint64_t now, bool level)
{
    struct bus_trace *trace = owner;
    vcd_change(trace->vcd, trace->rxd, now, level);
}

static unsigned declare(struct bus_trace *trace, const char *name)
{
    char full[VCD_NAME_ROOM];
    snprintf(full, sizeof(full), "bus%u_%s", trace->bus, name);
    return vcd_signal(trace->vcd, full, 1);
}

void bus_trace_init(struct bus_trace *trace, struct vcd *vcd, unsigned bus, struct wire *wire)
{
    *trace = (struct bus_trace){.vcd = vcd, .bus = bus, .wire = wire};
    if (!vcd->file) {
        return;
    }
    trace->sig = declare(trace, "wire");
    trace->controller = declare(trace, "controller_talks");
    trace->tx_enable = declare(trace, "tx_enable");
    trace->rx_enable = declare(trace, "rx_enable");
    trace->txd = declare(trace, "txd");
    trace->rxd = declare(trace, "rxd");
    trace->on_sig = (struct listener){trace, sig_changed, 0, 0};
    trace->on_txd = (struct listener){trace, txd_changed, 0, 0};
    trace->on_rxd = (struct listener){trace, rxd_changed, 0, 0};
    net_listen(&wire->sig, &trace->on_sig);
    net_listen(&wire->txd, &trace->on_txd);
    net_listen(&wire->rxd, &trace->on_rxd);
    sig_changed(trace, 0, wire->sig.level);
    txd_changed(trace, 0, wire->txd.level);
    rxd_changed(trace, 0, wire->rxd.level);
    bus_trace_wire(trace, 0);
}

void bus_trace_wire(struct bus_trace *trace, uint64_t now)
{
    const struct wire *wire = trace->wire;
    vcd_change(trace->vcd, trace->tx_enable, now, wire->tx_enable);
    vcd_change(trace->vcd, trace->rx_enable, now, wire->rx_enable);
    vcd_change(trace->vcd, trace->controller, now, wire->usart.talker.busy);
}

void bus_trace_servo(struct bus_trace *trace, uint64_t now, const struct servo_node *node)
{
    if (trace->vcd->file) {
        char name[32];
        snprintf(name, sizeof(name), "servo%u_talks", node->id);
        vcd_change(trace->vcd, declare(trace, name), now, node->driver.enabled);
    }
}

/* --- motion --------------------------------------------------------------------------------------
 */

static void write_row(void *owner, uint64_t now)
{
    struct motion *motion = owner;
    fprintf(motion->file, "%.3f", (double)now * 1000.0 / motion->clock_Hz);
    for (unsigned i = 0; i < motion->servos->count; i++) {
        const struct servo *servo = &motion->servos->node[i].servo;
        fprintf(motion->file, ",%u,%u", servo_goal_position(servo), servo_present_position(servo));
    }
    fputc('\n', motion->file);
    schedule_at(motion->schedule, &motion->sample, now + motion->clock_Hz / 1000 * 4);
}

bool motion_open(struct motion *motion, const char *path, struct schedule *schedule,
                 const struct servos *servos, uint32_t clock_Hz)
{
    *motion = (struct motion){.schedule = schedule, .servos = servos, .clock_Hz = clock_Hz};
    event_init(&motion->sample, write_row, motion);
    motion->file = fopen(path, "w");
    if (!motion->file) {
        fprintf(stderr, "%s: %s\n", path, strerror(errno));
    }
    return motion->file != 0;
}

bool motion_close(struct motion *motion)
{
    bool good = !motion->file || (!ferror(motion->file) && fclose(motion->file) == 0);
    motion->file = 0;
    return good;
}

void motion_block(struct motion *motion, uint64_t now)
{
    if (!motion->file) {
        return;
    }
    fputs(motion->blocks++ ? "\n\ntime_ms" : "time_ms", motion->file);
    for (unsigned i = 0; i < motion->servos->count; i++) {
        unsigned id = motion->servos->node[i].id;
        fprintf(motion->file, ",goal_%u,present_%u", id, id);
    }
    fputc('\n', motion->file);
    write_row(motion, now);
}
