/* SPDX-License-Identifier: MIT */
/* cds55xx-sim: simulates CDS55xx servos and the AVR of their controller. This file is the command
 * line. */
#include <ctype.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "data_path.h"
#include "host/realtime.h"
#include "output/files.h"
#include "output/named_files.h"
#include "testbench.h"

#define SECONDS_MIN 1e-6
#define SECONDS_MAX 1e6
#define SLOW_MAX    100
#define TCP_PREFIX  "tcp:"
#define TEXT(word)  #word
#define TEXT_OF(w)  TEXT(w)

enum { EXIT_GOOD = 0, EXIT_FAILED = 1, EXIT_USAGE = 2 };

/* File scope: a signal handler ends its run, and it is too big for the stack. */
static struct testbench bench;

static const char help[] =
    "cds55xx-sim firmware ELF --board NAME [options]\n"
    "runs the ELF on the board's simulated AVR, with simulated CDS55xx servos on its bus.\n"
    "\n"
    "cds55xx-sim bus --servos LIST --pty [options]\n"
    "the servos alone, behind a pty as through a USB2Dynamixel, in real time; its path is the\n"
    "first line printed: docs/simulated-bus.md. Without --pty: --script or --seconds, as fast\n"
    "as it goes.\n"
    "\n"
    "cds55xx-sim poke SOCKET ORDER\n"
    "gives an order to a simulator that runs with --poke SOCKET: a line of a scenario without its\n"
    "@, as in \"load 1 300\" or \"power 2 off\": docs/simulator.md\n"
    "\n"
    "  --board NAME       a board that comes with the simulator, as in atmega128\n"
    "  --board FILE       or a board.h of yours, with a board.mk beside it\n"
    "  --servos LIST      IDs of the servos, as in 1-18 or 0,1,5-7, or none (default);\n"
    "                     1:LIST are those on bus 1 of a board with several\n"
    "  --script FILE      run a scenario, docs/scenario.md: commands, changes of the\n"
    "                     environment, expectations; ends with its last line\n"
    "  --host pty         open a terminal for the console, print its path, run in real time\n"
    "  --host tcp:PORT    the same at a TCP port of 127.0.0.1, one client at a time; PORT 0: any\n"
    "  --host-baud client the PC's rate is the one set at the pty, not the board's\n"
    "  --host FILE        (with a . or / in it) a program of the PC's: what it says and waits for, "
    "docs/simulator.md\n"
    "  --host stdout      print what the firmware says, also beside --script; ends when it sleeps\n"
    "                     with interrupts off\n"
    "  --echo             show commands, replies and packets as they come\n"
    "  --transcript FILE  every packet on the wire, with the cycle of its first start bit\n"
    "  --vcd FILE         waveforms of the bus, for GTKWave\n"
    "  --csv FILE         goal and present position of every servo, every 4 ms\n"
    "  --plot FILE.svg    a picture: senders over time, and where the servos are (gnuplot)\n"
    "  --panes WHAT       add panes to --plot: speed, load, or speed,load\n"
    "  --eeprom FILE      keep the AVR's EEPROM from run to run\n"
    "  --mark PIN         how much of the time that pin is high, as in B0, handlers not counted\n"
    "  --times FILE       what happened when, to the cycle, and how long handlers took\n"
    "  --stamp PORT       add each change of the pins of PORT, as B, to --times\n"
    "  --steps FROM-TO    add each instruction of the cycles FROM to TO to --times\n"
    "  --gdb PORT         wait for avr-gdb (target remote 127.0.0.1:PORT) before all else\n"
    "  --rules warn       tell and count what breaks the rules of the wire, but do not fail\n"
    "  --state DIR        keep what each servo has in its EEPROM from run to run\n"
    "  --follow           a live table of the servos on stderr\n"
    "  --poke SOCKET      take orders from `cds55xx-sim poke SOCKET ORDER` (with --host pty, tcp "
    "or "
    "--pty)\n"
    "  --poke-hint TEXT   the command for orders that the first lines name; make run sets it\n"
    "  --slow N           simulated time runs N times slower than real time, 1 to 100 (with --host "
    "pty, tcp\n"
    "                     or --pty)\n"
    "  --fault ORDER      inject a fault, as in --fault \"flip out 1 4 3\": docs/faults.md; any "
    "number\n"
    "  --seed N           of all that happens at random; 0 (default) to 4294967295\n"
    "  --allow-duplicates several servos may have one ID\n"
    "  --seconds S        end after so much simulated time\n"
    "  --usart exact      USARTs as in the data sheet (default)\n"
    "  --usart stock      simavr's own USARTs and interrupt entry, for comparison\n"
    "  --help, --version  this list; the version, as in 0.1.0\n"
    "\n"
    "Exit status: 0 good; 1 the run failed (a rule was broken, an error reply, a crash); 2 bad "
    "input,\n"
    "or an output that could not be written.\n";

static bool usage(const char *what, const char *word)
{
    fprintf(stderr, "cds55xx-sim: %s%s%s (try --help)\n", what, word ? ": " : "", word ? word : "");
    return false;
}

/* Accepts digits only. */
static bool parse_whole(const char *value, unsigned long max, unsigned long *number)
{
    char *end = 0;
    errno = 0;
    *number = isdigit((unsigned char)*value) ? strtoul(value, &end, 10) : 0;
    return end && !*end && errno == 0 && *number <= max;
}

static bool parse_tcp(struct testbench_options *options, const char *text)
{
    unsigned long port = 0;
    bool good = parse_whole(text, UINT16_MAX, &port);
    options->host = TESTBENCH_HOST_TCP;
    options->tcp_port = (uint16_t)port;
    return good || usage("--host tcp:PORT wants a port, 0 (any) to 65535, not", text);
}

static bool parse_host(struct testbench_options *options, const char *value)
{
    if (options->host == TESTBENCH_HOST_SCRIPT && strcmp(value, "stdout") == 0) {
        options->prints_text = true;
        return true;
    }
    if (options->host != TESTBENCH_HOST_NONE) {
        return usage("only one --host, and with --script only --host stdout", 0);
    }
    if (strncmp(value, TCP_PREFIX, strlen(TCP_PREFIX)) == 0) {
        return parse_tcp(options, value + strlen(TCP_PREFIX));
    }
    if (strcmp(value, "pty") == 0) {
        options->host = TESTBENCH_HOST_PTY;
    } else if (strcmp(value, "stdout") == 0) {
        options->host = TESTBENCH_HOST_STDOUT;
    } else if (strpbrk(value, "./")) {
        options->host = TESTBENCH_HOST_PC;
        options->pc = value;
    } else {
        return usage("--host is pty, tcp:PORT, stdout or a file, not", value);
    }
    return true;
}

static bool parse_host_baud(struct testbench_options *options, const char *value)
{
    options->client_baud = strcmp(value, "client") == 0;
    return options->client_baud || strcmp(value, "board") == 0 ||
           usage("--host-baud is board or client, not", value);
}

static bool parse_script(struct testbench_options *options, const char *value)
{
    options->prints_text = options->host == TESTBENCH_HOST_STDOUT;
    if (options->host != TESTBENCH_HOST_NONE && !options->prints_text) {
        return usage("only one --script, and with it only --host stdout", 0);
    }
    options->host = TESTBENCH_HOST_SCRIPT;
    options->script = value;
    return true;
}

static bool parse_seconds(struct testbench_options *options, const char *value)
{
    char *end = 0;
    bool decimal =
        value[0] && !value[strspn(value, "0123456789.eE+-")]; // no space, no "nan", no 0x
    options->seconds = decimal ? strtod(value, &end) : 0;
    return (decimal && !*end && options->seconds >= SECONDS_MIN &&
            options->seconds <= SECONDS_MAX) ||
           usage("--seconds wants a positive number, 0.000001 to 1000000, not", value);
}

static bool parse_servos(struct testbench_options *options, const char *value)
{
    if (strcmp(value, "none") == 0) {
        return true;
    }
    unsigned bus = 0;
    const char *list = value;
    if (isdigit((unsigned char)value[0]) && value[1] == ':') {
        bus = (unsigned)(value[0] - '0');
        list = value + 2;
    }
    if (bus >= BOARD_BUSES_MAX) {
        return usage("buses are 0 to 2", value);
    }
    struct testbench_servos *servos = &options->servos[bus];
    const char *wrong = ids_parse(list, true, servos->ids, &servos->count);
    return !wrong || usage(wrong, value);
}

/* Accepts speed and load in any order, with a comma between them. */
static bool parse_panes(struct testbench_options *options, const char *value)
{
    const char *word = value;
    for (;;) {
        size_t length = strcspn(word, ",");
        if (length == strlen("speed") && strncmp(word, "speed", length) == 0) {
            options->panes.speed = true;
        } else if (length == strlen("load") && strncmp(word, "load", length) == 0) {
            options->panes.load = true;
        } else {
            return usage("--panes is speed, load or speed,load, not", value);
        }
        if (!word[length]) {
            return true;
        }
        word += length + 1;
    }
}

static bool parse_fault(struct testbench_options *options, const char *value)
{
    const char *wrong = faults_check(value);
    if (wrong) {
        return usage("--fault", wrong);
    }
    if (options->fault_count == TESTBENCH_FAULTS_MAX) {
        return usage("more than 64 times --fault", 0);
    }
    options->faults[options->fault_count++] = value;
    return true;
}

static bool parse_seed(struct testbench_options *options, const char *value)
{
    unsigned long seed = 0;
    bool good = parse_whole(value, UINT32_MAX, &seed);
    options->seed = (uint32_t)seed;
    return good || usage("--seed wants 0 to 4294967295, not", value);
}

static bool parse_slow(struct testbench_options *options, const char *value)
{
    bool good = parse_whole(value, SLOW_MAX, &options->slow) && options->slow > 0;
    return good || usage("--slow wants 1 to 100, not", value);
}

static bool parse_rules(struct testbench_options *options, const char *value)
{
    options->rules_warn = strcmp(value, "warn") == 0;
    return options->rules_warn || strcmp(value, "fail") == 0 ||
           usage("--rules is fail or warn, not", value);
}

static bool parse_gdb(struct testbench_options *options, const char *value)
{
    unsigned long port = 0;
    bool good = parse_whole(value, UINT16_MAX, &port);
    options->gdb = true;
    options->gdb_port = (uint16_t)port;
    return good || usage("--gdb wants a port, 0 (any) to 65535, not", value);
}

static bool parse_usart(struct testbench_options *options, const char *value)
{
    options->exact = strcmp(value, "exact") == 0;
    return options->exact || strcmp(value, "stock") == 0 ||
           usage("--usart is exact or stock, not", value);
}

static bool parse_option(struct testbench_options *options, const char *name, const char *value)
{
    const struct {
        const char *name;
        const char **text; // stores the value as it is
        bool (*parse)(struct testbench_options *options, const char *value);
    } known[] = {
        {"--board", &options->board, 0},
        {"--servos", 0, parse_servos},
        {"--script", 0, parse_script},
        {"--host", 0, parse_host},
        {"--host-baud", 0, parse_host_baud},
        {"--transcript", &options->transcript, 0},
        {"--vcd", &options->vcd, 0},
        {"--csv", &options->csv, 0},
        {"--plot", &options->plot, 0},
        {"--panes", 0, parse_panes},
        {"--eeprom", &options->eeprom, 0},
        {"--mark", &options->cycles.mark, 0},
        {"--times", &options->cycles.times, 0},
        {"--stamp", &options->cycles.stamp, 0},
        {"--poke", &options->poke, 0},
        {"--poke-hint", &options->poke_hint, 0},
        {"--gdb", 0, parse_gdb},
        {"--rules", 0, parse_rules},
        {"--state", &options->state, 0},
        {"--seconds", 0, parse_seconds},
        {"--fault", 0, parse_fault},
        {"--seed", 0, parse_seed},
        {"--slow", 0, parse_slow},
        {"--usart", 0, parse_usart},
        {"--steps", &options->cycles.steps, 0},
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

static bool *find_switch(struct testbench_options *options, const char *name)
{
    return strcmp(name, "--echo") == 0               ? &options->echo
           : strcmp(name, "--follow") == 0           ? &options->follow
           : strcmp(name, "--pty") == 0              ? &options->pty
           : strcmp(name, "--allow-duplicates") == 0 ? &options->allow_duplicates
                                                     : 0;
}

static bool check_realtime(const struct testbench_options *options)
{
    bool realtime =
        options->pty || options->host == TESTBENCH_HOST_PTY || options->host == TESTBENCH_HOST_TCP;
    if (options->poke && (!realtime || options->script)) {
        return usage("--poke is for a run in real time without --script", 0);
    }
    return !options->slow || realtime || usage("--slow is for a run in real time", 0);
}

static bool check_firmware(const struct testbench_options *options)
{
    if (!options->elf || !options->board) {
        return usage("an ELF file and --board are wanted", 0);
    }
    if (options->pty) {
        return usage("with a firmware it is --host pty", 0);
    }
    if (options->client_baud && options->host == TESTBENCH_HOST_TCP) {
        return usage("a TCP client has no rate: no --host-baud client", 0);
    }
    return options->host != TESTBENCH_HOST_NONE || options->seconds > 0 ||
           usage("without --script and --host, --seconds is wanted", 0);
}

static bool check_ids(const struct testbench_options *options)
{
    for (unsigned bus = 0; bus < BOARD_BUSES_MAX; bus++) {
        const struct testbench_servos *servos = &options->servos[bus];
        bool seen[IDS_MAX] = {false};
        for (unsigned i = 0; i < servos->count; i++) {
            if (seen[servos->ids[i]] && !options->allow_duplicates) {
                return usage("an ID occurs twice, and there is no --allow-duplicates", 0);
            }
            seen[servos->ids[i]] = true;
        }
    }
    return true;
}

static bool check_bus(const struct testbench_options *options)
{
    if (options->elf || options->board || !options->exact || options->gdb || options->eeprom ||
        options->cycles.mark || options->cycles.times || options->cycles.stamp ||
        options->cycles.steps || options->prints_text ||
        (options->host != TESTBENCH_HOST_NONE && !options->script)) {
        return usage("a bus has no firmware: no ELF, no --board, --host, --usart, --gdb, --eeprom, "
                     "--mark, --times, --stamp, --steps",
                     0);
    }
    if (options->servos[1].count || options->servos[2].count) {
        return usage("there is one bus only: --servos LIST", 0);
    }
    return options->pty || options->script || options->seconds > 0 ||
           usage("without --pty and --script, --seconds is wanted", 0);
}

static bool parse(struct testbench_options *options, int argc, char **argv)
{
    options->bus = argc >= 2 && strcmp(argv[1], "bus") == 0;
    if (argc < 2 || (!options->bus && strcmp(argv[1], "firmware") != 0)) {
        return usage("the first word must be: firmware, bus, or: poke", 0);
    }
    for (int i = 2; i < argc; i++) {
        bool *flag = find_switch(options, argv[i]);
        if (flag) {
            *flag = true;
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
    if ((options->panes.speed || options->panes.load) && !options->plot) {
        return usage("--panes is for --plot", 0);
    }
    return check_ids(options) && check_realtime(options) &&
           (options->bus ? check_bus(options) : check_firmware(options));
}

/* cds55xx-sim poke SOCKET ORDER: the words of the order may be one argument or several. */
static int poke(int argc, char **argv)
{
    char order[POKE_LINE_SIZE] = "";
    size_t size = 0;
    for (int i = 3; i < argc && size < sizeof(order); i++) {
        size +=
            (size_t)snprintf(order + size, sizeof(order) - size, "%s%s", i > 3 ? " " : "", argv[i]);
    }
    if (size == 0 || size >= sizeof(order) || strchr(order, '\n')) {
        usage("poke wants a socket and an order of one line, as in: poke build/atmega128/poke "
              "\"load 1 300\"",
              0);
        return EXIT_USAGE;
    }
    enum poke_result result = poke_send(argv[2], order);
    return result == POKE_OK ? EXIT_GOOD : result == POKE_ERROR ? EXIT_FAILED : EXIT_USAGE;
}

static void interrupted(int signal_number)
{
    (void)signal_number;
    testbench_stop(&bench);
}

/* A signal ends the run, and all its files are written: Ctrl-C, a closed terminal (SIGHUP, unless
 * nohup ignores it), a reader of stdout that has left (SIGPIPE). */
static void end_on_signals(void)
{
    signal(SIGINT, interrupted);
    signal(SIGTERM, interrupted);
    signal(SIGPIPE, interrupted);
    if (signal(SIGHUP, interrupted) == SIG_IGN) {
        signal(SIGHUP, SIG_IGN);
    }
}

static int run(const struct testbench_options *options)
{
    bool ready = testbench_init(&bench, options);
    bool good = false;
    if (ready) {
        end_on_signals();
        uint64_t start = realtime_now_ns();
        good = testbench_run(&bench);
        testbench_report(&bench, stdout);
        double took = (double)(realtime_now_ns() - start) * 1e-9;
        double simulated = (double)bench.end / bench.clock_Hz;
        if (isatty(STDERR_FILENO)) {
            fprintf(stderr, "speed: %.1f x real time\n", took > 0 ? simulated / took : 0.0);
        }
    }
    bool written = testbench_free(&bench);
    written = files_flush_stdout() && written;
    if (bench.cannot_listen) {
        return EXIT_FAILED;
    }
    return !ready || !written ? EXIT_USAGE : good ? EXIT_GOOD : EXIT_FAILED;
}

int main(int argc, char **argv)
{
    char boards[DATA_PATH_SIZE];
    data_path(boards, "boards");
    struct testbench_options options = {.boards = boards, .exact = true};
    setvbuf(stdout, 0, _IOLBF, 0); // progress shall appear at once, also in a pipe
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0) {
            fputs(help, stdout);
            return files_flush_stdout() ? EXIT_GOOD : EXIT_USAGE;
        }
        if (strcmp(argv[i], "--version") == 0) {
            puts("cds55xx-sim " TEXT_OF(SIM_VERSION));
            return files_flush_stdout() ? EXIT_GOOD : EXIT_USAGE;
        }
    }
    if (argc >= 2 && strcmp(argv[1], "poke") == 0) {
        return poke(argc, argv);
    }
    bool good = parse(&options, argc, argv) && named_files_check(&options);
    return good ? run(&options) : EXIT_USAGE;
}
