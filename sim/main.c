/* cds55xx-sim: runs the firmware of a servo controller in a simulated AVR, with simulated servos.
 */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bench.h"

#ifndef SIM_BOARDS_DIR
#define SIM_BOARDS_DIR "boards"
#endif

enum { EXIT_GOOD = 0, EXIT_FAILED = 1, EXIT_USAGE = 2 };

static struct bench bench; // SIGINT ends its run; it is also too big for the stack

static const char help[] =
    "cds55xx-sim firmware ELF --board NAME [options]\n"
    "runs the ELF on the board's simulated AVR, with simulated CDS55xx servos on its bus.\n"
    "\n"
    "  --board NAME       a folder below " SIM_BOARDS_DIR "\n"
    "  --servos LIST      IDs of the servos, as in 1-18 or 0,1,5-7, or none (default)\n"
    "  --script FILE      say its lines to the firmware's console, end with the last reply;\n"
    "                     ! expects an error; @servos @power @wait @print @echo, # comment\n"
    "  --host pty         open a terminal for the console, print its path, run in real time\n"
    "  --host stdout      print what the firmware says; ends when it sleeps with interrupts off\n"
    "  --echo             show commands, replies and packets as they come\n"
    "  --transcript FILE  every packet on the wire, with the cycle of its first start bit\n"
    "  --vcd FILE         waveforms of the bus, for GTKWave\n"
    "  --csv FILE         goal and present position of every servo, every 4 ms\n"
    "  --seconds S        end after so much simulated time\n"
    "  --usart exact      USARTs as in the data sheet (default)\n"
    "  --usart stock      simavr's own USARTs and interrupt entry, for comparison\n"
    "\n"
    "Exit status: 0 good; 1 the run failed (a rule was broken, an error reply, a crash); 2 bad "
    "input.\n";

static bool usage(const char *what, const char *word)
{
    fprintf(stderr, "cds55xx-sim: %s%s%s (try --help)\n", what, word ? ": " : "", word ? word : "");
    return false;
}

static bool parse_host(struct bench_options *options, const char *value)
{
    if (options->host != BENCH_HOST_NONE) {
        return usage("one of --script and --host, and only once", 0);
    }
    if (strcmp(value, "pty") == 0) {
        options->host = BENCH_HOST_PTY;
    } else if (strcmp(value, "stdout") == 0) {
        options->host = BENCH_HOST_STDOUT;
    } else {
        return usage("--host is pty or stdout, not", value);
    }
    return true;
}

static bool parse_script(struct bench_options *options, const char *value)
{
    if (options->host != BENCH_HOST_NONE) {
        return usage("one of --script and --host, and only once", 0);
    }
    options->host = BENCH_HOST_SCRIPT;
    options->script = value;
    return true;
}

static bool parse_seconds(struct bench_options *options, const char *value)
{
    char *end = 0;
    options->seconds = strtod(value, &end);
    if (*end || !(options->seconds > 0 && options->seconds <= 1e6)) {
        return usage("--seconds wants a positive number, not", value);
    }
    return true;
}

static bool parse_servos(struct bench_options *options, const char *value)
{
    if (strcmp(value, "none") == 0) {
        return true;
    }
    const char *wrong = ids_parse(value, false, options->ids, &options->servos);
    return !wrong || usage(wrong, value);
}

static bool parse_usart(struct bench_options *options, const char *value)
{
    options->exact = strcmp(value, "exact") == 0;
    return options->exact || strcmp(value, "stock") == 0 ||
           usage("--usart is exact or stock, not", value);
}

static bool parse_option(struct bench_options *options, const char *name, const char *value)
{
    const struct {
        const char *name;
        const char **text; // keep the value as it is
        bool (*parse)(struct bench_options *options, const char *value);
    } known[] = {
        {"--board", &options->board, 0},
        {"--servos", 0, parse_servos},
        {"--script", 0, parse_script},
        {"--host", 0, parse_host},
        {"--transcript", &options->transcript, 0},
        {"--vcd", &options->vcd, 0},
        {"--csv", &options->csv, 0},
        {"--seconds", 0, parse_seconds},
        {"--usart", 0, parse_usart},
    };
    for (size_t i = 0; i < sizeof(known) / sizeof(known[0]); i++) {
        if (strcmp(name, known[i].name) != 0) {
            continue;
        }
        if (!value) {
            return usage("a value is missing behind", name);
        }
        if (known[i].text) {
            *known[i].text = value;
            return true;
        }
        return known[i].parse(options, value);
    }
    return usage("unknown option", name);
}

static bool parse(struct bench_options *options, int argc, char **argv)
{
    if (argc < 2 || strcmp(argv[1], "firmware") != 0) {
        return usage("the first word must be: firmware", 0);
    }
    for (int i = 2; i < argc; i++) {
        if (strcmp(argv[i], "--echo") == 0) {
            options->echo = true;
        } else if (argv[i][0] != '-') {
            if (options->elf) {
                return usage("one ELF file only, not also", argv[i]);
            }
            options->elf = argv[i];
        } else if (!parse_option(options, argv[i], i + 1 < argc ? argv[i + 1] : 0)) {
            return false;
        } else {
            i++;
        }
    }
    if (!options->elf || !options->board) {
        return usage("an ELF file and --board are wanted", 0);
    }
    if (options->host == BENCH_HOST_NONE && options->seconds <= 0) {
        return usage("without --script and --host, --seconds is wanted", 0);
    }
    return true;
}

static void interrupted(int signal_number)
{
    (void)signal_number;
    machine_stop(&bench.machine);
}

static double real_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

static int run(const struct bench_options *options)
{
    bool ready = bench_init(&bench, options);
    bool good = false;
    if (ready) {
        signal(SIGINT, interrupted);
        signal(SIGTERM, interrupted);
        double start = real_seconds();
        good = bench_run(&bench);
        double took = real_seconds() - start;
        bench_report(&bench, stdout);
        double simulated = (double)bench.end / bench.board.clock_Hz;
        fprintf(stderr, "speed: %.1f x real time\n", took > 0 ? simulated / took : 0.0);
    }
    bool written = bench_free(&bench);
    if (!written) {
        fputs("cds55xx-sim: an output file could not be written\n", stderr);
    }
    return !ready || !written ? EXIT_USAGE : good ? EXIT_GOOD : EXIT_FAILED;
}

int main(int argc, char **argv)
{
    struct bench_options options = {.boards = SIM_BOARDS_DIR, .exact = true};
    setvbuf(stdout, 0, _IOLBF, 0); // progress is to be seen when it happens, in a pipe too
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0) {
            fputs(help, stdout);
            return EXIT_GOOD;
        }
    }
    return parse(&options, argc, argv) ? run(&options) : EXIT_USAGE;
}
