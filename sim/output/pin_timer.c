#include "output/pin_timer.h"

#include <inttypes.h>
#include <string.h>

static void rise(struct mark *mark, uint64_t now)
{
    mark->high = true;
    mark->since = now;
    mark->in_handlers = mark->cpu->in_handlers;
    mark->times++;
}

static void fall(struct mark *mark, uint64_t now)
{
    uint64_t took = now - mark->since - (mark->cpu->in_handlers - mark->in_handlers);
    mark->high = false;
    mark->cycles += took;
    mark->longest = took > mark->longest ? took : mark->longest;
}

static void pins_changed(struct avr_irq_t *irq, uint32_t value, void *param)
{
    (void)irq, (void)value;
    struct mark *mark = param;
    bool high = pin_state(&mark->pin) == PIN_HIGH;
    if (high && !mark->high) {
        rise(mark, mark->cpu->avr->cycle);
    } else if (!high && mark->high) {
        fall(mark, mark->cpu->avr->cycle);
    }
}

bool mark_open(struct mark *mark, const struct cpu *cpu, const char *name)
{
    *mark = (struct mark){.name = name, .cpu = cpu};
    if (strlen(name) != 2 || !pin_find(&mark->pin, cpu->avr, name[0], (unsigned)(name[1] - '0'))) {
        fprintf(stderr, "--mark %s: the chip has no such pin; wanted: port and bit, as in B0\n",
                name);
        return false;
    }
    pin_watch(&mark->pin, pins_changed, mark);
    return true;
}

void mark_report(struct mark *mark, uint64_t now, FILE *out)
{
    if (!mark->name) {
        return;
    }
    if (mark->high) {
        fall(mark, now);
    }
    fprintf(out,
            "mark:    P%s high %.2f %% of the time without handlers; %" PRIu32 " times, %" PRIu64
            " cycles at most, %" PRIu64 " in all\n",
            mark->name, now ? 100.0 * (double)mark->cycles / (double)now : 0.0, mark->times,
            mark->longest, mark->cycles);
}
