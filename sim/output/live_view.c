#include "output/live_view.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include "host/realtime.h"

#define LOOKS_A_SECOND 50
#define TERMINAL_NS    100000000ull
#define PLAIN_NS       1000000000ull
#define CW             0x400 // bit 10 of speed and load
#define DEGREES        (300.0 / 1023.0)

static unsigned word(const struct servo *servo, uint8_t address)
{
    return table_get(servo->registers, address, 2);
}

static int with_sign(unsigned value)
{
    return value & CW ? -(int)(value & 0x3FF) : (int)(value & 0x3FF);
}

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

/* Lines end so that nothing is left of what stood there before. */
static void end_line(struct follow *follow)
{
    fputs(follow->terminal ? "\033[K\n" : "\n", follow->out);
    follow->lines++;
}

static void draw_servo(struct follow *follow, unsigned bus, const struct servo *servo)
{
    char text[64];
    const uint8_t *now = servo->registers;
    fprintf(follow->out, "%3u %3u %6.1f %7.1f %6d %5d %5.1f %3u  %-3s %-3s  %s", bus, now[TABLE_ID],
            servo_goal_position(servo) * DEGREES, servo_present_position(servo) * DEGREES,
            with_sign(word(servo, TABLE_PRESENT_SPEED)), with_sign(word(servo, TABLE_PRESENT_LOAD)),
            now[TABLE_PRESENT_VOLTAGE] / 10.0, now[TABLE_PRESENT_TEMPERATURE],
            !servo->powered       ? "-"
            : servo_torque(servo) ? "on"
                                  : "off",
            servo_led(servo) ? "*" : "", servo->powered ? errors(servo, text) : "no power");
    end_line(follow);
}

/* Servos for which there is room: a picture higher than the screen could not be drawn over. */
static unsigned room(const struct follow *follow)
{
    struct winsize size;
    bool known = follow->terminal && ioctl(fileno(follow->out), TIOCGWINSZ, &size) == 0;
    return !known || size.ws_row == 0 ? IDS_MAX * BOARD_BUSES_MAX
           : size.ws_row > 5          ? size.ws_row - 4u
                                      : 1;
}

/* The cursor stays above the picture, so that what others print pushes it down. */
void follow_draw(struct follow *follow, uint64_t now)
{
    if (!follow->out) {
        return;
    }
    unsigned left = room(follow);
    unsigned hidden = 0;
    follow->lines = 0;
    fprintf(follow->out, "%s%.2f s", follow->terminal ? "\r\033[J" : "",
            (double)now / follow->clock_Hz);
    end_line(follow);
    fputs("bus  ID   goal present  speed  load     V   C  torque LED  errors", follow->out);
    end_line(follow);
    for (unsigned bus = 0; bus < follow->buses; bus++) {
        for (unsigned i = 0; i < follow->bus[bus]->count; i++) {
            if (left) {
                left--;
                draw_servo(follow, bus, &follow->bus[bus]->node[i].servo);
            } else {
                hidden++;
            }
        }
    }
    if (hidden) {
        fprintf(follow->out, "and %u more: the terminal is too low", hidden);
        end_line(follow);
    }
    if (follow->terminal) {
        fprintf(follow->out, "\033[%uA", follow->lines);
    }
    fflush(follow->out);
    follow->drawn_ns = pace_real_ns();
}

static void look(void *owner, uint64_t now)
{
    struct follow *follow = owner;
    if (pace_real_ns() - follow->drawn_ns >= (follow->terminal ? TERMINAL_NS : PLAIN_NS)) {
        follow_draw(follow, now);
    }
    schedule_at(follow->schedule, &follow->look, now + follow->clock_Hz / LOOKS_A_SECOND);
}

void follow_init(struct follow *follow, FILE *out, struct schedule *schedule, uint32_t clock_Hz)
{
    *follow = (struct follow){.out = out, .schedule = schedule, .clock_Hz = clock_Hz};
    follow->terminal = isatty(fileno(out));
    event_init(&follow->look, look, follow);
    schedule_at(schedule, &follow->look, schedule->now);
}

void follow_bus(struct follow *follow, const struct servos *servos)
{
    if (follow->out) {
        follow->bus[follow->buses++] = servos;
    }
}

void follow_end(struct follow *follow, uint64_t now)
{
    follow_draw(follow, now);
    if (follow->out && follow->terminal) {
        fprintf(follow->out, "\033[%uB\n", follow->lines);
    }
}
