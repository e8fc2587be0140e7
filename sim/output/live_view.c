/* SPDX-License-Identifier: MIT */
#include "output/live_view.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include "host/realtime.h"

#define LOOKS_A_SECOND 50
#define TERMINAL_NS    100000000ull
#define PLAIN_NS       1000000000ull
#define DEGREES        (300.0 / 1023.0)
#define RPM            (62.0 / 1023.0)
#define PERCENT        (100.0 / 1023.0)
#define OPEN_LINE_NS   1000000000ull // a line of text that does not end is ended after this time
#define STDOUT_BYTES   65536

static const char *errors(const struct servo *servo, char text[64])
{
    static const char *const name[] = {"voltage",  "angle",    "heat",       "range",
                                       "checksum", "overload", "instruction"};
    size_t size = 0;
    text[0] = 0;
    for (unsigned bit = 0; bit < sizeof(name) / sizeof(name[0]); bit++) {
        if (servo_errors(servo) >> bit & 1) {
            size += (size_t)snprintf(text + size, 64 - size, "%s%s", size ? " " : "", name[bit]);
        }
    }
    return text;
}

/* Erases the line from the cursor on. */
static void end_line(struct live_view *view)
{
    fputs(view->terminal ? "\033[K\n" : "\n", view->out);
    view->lines++;
}

static void draw_servo(struct live_view *view, unsigned bus, const struct servo *servo)
{
    char text[64];
    const uint8_t *now = servo->registers;
    fprintf(view->out, "%3u %3u %6.1f %7.1f %5.1f %4.0f %6.1f %4u  %-6s %-3s  %s", bus,
            now[TABLE_ID], servo_goal_position(servo) * DEGREES,
            servo_present_position(servo) * DEGREES, servo_present_speed(servo) * RPM,
            servo_present_load(servo) * PERCENT, now[TABLE_PRESENT_VOLTAGE] / 10.0,
            now[TABLE_PRESENT_TEMPERATURE],
            !servo->powered       ? "-"
            : servo_torque(servo) ? "on"
                                  : "off",
            servo_led(servo) ? "*" : "", servo->powered ? errors(servo, text) : "no power");
    end_line(view);
}

/* Returns how many servos fit: a table higher than the screen could not be drawn over. */
static unsigned visible_rows(const struct live_view *view)
{
    struct winsize size;
    bool known = view->terminal && ioctl(fileno(view->out), TIOCGWINSZ, &size) == 0;
    return !known || size.ws_row == 0 ? IDS_MAX * BOARD_BUSES_MAX
           : size.ws_row > 6          ? size.ws_row - 5u
                                      : 1;
}

/* True if text that has no end of its line yet would stand where the table begins. */
static bool line_is_open(const struct live_view *view)
{
    return view->keeps_stdout && *view->line_is_open;
}

/* Erases the table, and prints above it what stdout has kept since the last one. */
static void make_room(struct live_view *view)
{
    if (!view->terminal) {
        return;
    }
    fputs("\r\033[J", view->out);
    fflush(view->out);
    if (line_is_open(view)) {
        fputc('\n', stdout);
        *view->line_is_open = false;
    }
    fflush(stdout);
}

/* The cursor stays above the table, so output of other programs pushes the table down. */
static void draw_table(struct live_view *view, uint64_t now)
{
    if (!view->out) {
        return;
    }
    unsigned rows_left = visible_rows(view);
    unsigned hidden = 0;
    view->lines = 0;
    make_room(view);
    fprintf(view->out, "%.2f s", (double)now / view->clock_Hz);
    end_line(view);
    fputs("bus  ID   goal present speed load supply temp  torque LED  errors", view->out);
    end_line(view);
    fputs("           deg     deg   RPM    %      V    C", view->out);
    end_line(view);
    for (unsigned bus = 0; bus < view->buses; bus++) {
        for (unsigned i = 0; i < view->bus[bus]->count; i++) {
            if (rows_left) {
                rows_left--;
                draw_servo(view, bus, &view->bus[bus]->node[i].servo);
            } else {
                hidden++;
            }
        }
    }
    if (hidden) {
        fprintf(view->out, "and %u more: the terminal is too low", hidden);
        end_line(view);
    }
    if (view->terminal) {
        fprintf(view->out, "\033[%uA", view->lines);
    }
    fflush(view->out);
    view->drawn_ns = realtime_now_ns();
}

static void refresh(void *context, uint64_t now)
{
    struct live_view *view = context;
    uint64_t pause = line_is_open(view) ? OPEN_LINE_NS : view->terminal ? TERMINAL_NS : PLAIN_NS;
    if (realtime_now_ns() - view->drawn_ns >= pause) {
        draw_table(view, now);
    }
    schedule_at(view->schedule, &view->refresh, now + view->clock_Hz / LOOKS_A_SECOND);
}

void live_view_init(struct live_view *view, FILE *out, struct schedule *schedule, uint32_t clock_Hz,
                    bool *line_is_open)
{
    *view = (struct live_view){
        .out = out, .schedule = schedule, .clock_Hz = clock_Hz, .line_is_open = line_is_open};
    view->terminal = isatty(fileno(out));
    view->keeps_stdout = view->terminal && isatty(STDOUT_FILENO);
    if (view->keeps_stdout) {
        setvbuf(stdout, 0, _IOFBF, STDOUT_BYTES); // make_room() prints it
    }
    event_init(&view->refresh, refresh, view);
    schedule_at(schedule, &view->refresh, schedule->now);
}

void live_view_add_bus(struct live_view *view, const struct servos *servos)
{
    if (view->out) {
        view->bus[view->buses++] = servos;
    }
}

void live_view_end(struct live_view *view, uint64_t now)
{
    draw_table(view, now);
    if (view->out && view->terminal) {
        fprintf(view->out, "\033[%uB\n", view->lines);
    }
}
