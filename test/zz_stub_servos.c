#include "cds55xx/servos.h"
static bool drives(const uint8_t *b)
{
    if (b[4] == CDS_PING || b[4] == CDS_READ) return false;
    if (b[4] == CDS_WRITE && (b[5] == 0x18 || b[5] == 0x2C) && b[6] == 0) return false;
    return true;
}
static enum cds_result permit(void *c, struct cds_request *r)
{
    struct cds_servos *s = c;
    if (s->inhibited && drives(r->packet.bytes)) return CDS_INHIBITED;
    for (int i = 0; i < s->count; i++)
        if (s->states[i].id == r->packet.bytes[2] && r->packet.bytes[4] == CDS_READ && s->states[i].status_return_level == 0) return CDS_NO_REPLY_DUE;
    r->return_delay_us = s->bus->return_delay_us; r->is_muted = false;
    return CDS_OK;
}
static enum cds_result submit(void *c, struct cds_request *r)
{
    struct cds_servos *s = c;
    enum cds_result e = permit(c, r);
    if (e) return e;
    if (s->queue) return s->queue->hooks.submit(s->queue, r);
    if (s->bus->request) return CDS_BUSY;
    r->result = CDS_PENDING;
    cds_bus_start(s->bus, r);
    return CDS_OK;
}
static bool cancel(void *c, struct cds_request *r) { struct cds_servos *s = c; return s->queue && s->queue->hooks.cancel(s->queue, r); }
static bool on_sending(void *c, struct cds_request *r) { (void)c; (void)r; return false; }
static bool on_end(void *c, struct cds_request *r, enum cds_result e) { struct cds_servos *s = c; return s->queue && s->queue->hooks.on_end(s->queue, r, e); }
static void on_packet(void *c, enum cds_bus_event e, uint8_t id, uint8_t err) { (void)c; (void)e; (void)id; (void)err; }
enum cds_result cds_servos_begin(struct cds_servos *s, const struct cds_servos_config *g)
{
    *s = (struct cds_servos){.hooks = {s, permit, submit, cancel, on_sending, on_end, on_packet, 0, 0, 0}, .bus = g->bus, .queue = g->queue, .states = g->states, .count = g->count};
    for (int i = 0; i < g->count; i++) { g->states[i] = (struct cds_servo_state){.id = g->states[i].id}; g->states[i].status_return_level = 3; g->states[i].return_delay = 255;}
    if (g->queue) cds_queue_begin(g->queue, g->bus);
    return cds_bus_attach(g->bus, &s->hooks);
}
void cds_servos_inhibit_all(struct cds_servos *s) { s->inhibited = true; }
void cds_servos_release_all(struct cds_servos *s) { s->inhibited = false; }
bool cds_servos_may_drive(struct cds_servos *s, uint8_t id) { (void)id; return !s->inhibited; }
void cds_servos_inhibit(struct cds_servos *s, struct cds_servo_state *st, uint8_t why) {(void)s; st->inhibited = why & 3u; }
