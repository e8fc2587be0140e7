/* SPDX-License-Identifier: MIT */
#include "avr/cpu.h"

static void notify(struct cpu *cpu)
{
    if (cpu->on_handler) {
        uint8_t vector = cpu->depth ? cpu->vectors[cpu->depth - 1] : 0;
        cpu->on_handler(cpu->context, cpu->avr->cycle, vector);
    }
}

void cpu_halt(avr_t *avr, avr_cycle_count_t cycles)
{
    avr->cycle += cycles;
    /* run_cycle_count limits how long simavr runs before its next timer. It was computed without
     * these cycles. */
    avr->run_cycle_count = avr->run_cycle_count > cycles ? avr->run_cycle_count - cycles : 1;
}

static void drop_pending(avr_t *avr, avr_int_vector_t *vector)
{
    avr_int_pending_t *fifo = &avr->interrupts.pending;
    unsigned kept = fifo->read;
    for (unsigned i = fifo->read; i != fifo->write; i = (i + 1) % avr_int_pending_fifo_size) {
        if (fifo->buffer[i] != vector) {
            fifo->buffer[kept] = fifo->buffer[i];
            kept = (kept + 1) % avr_int_pending_fifo_size;
        }
    }
    fifo->write = (__typeof__(fifo->write))kept;
    vector->pending = 0;
    if (fifo->read == fifo->write && avr->interrupt_state > 0) {
        avr->interrupt_state = 0;
    }
}

void cpu_set_level_interrupt(avr_t *avr, avr_int_vector_t *vector, bool on)
{
    if (on && !vector->pending) {
        avr_raise_interrupt(avr, vector);
    } else if (!on && vector->pending) {
        drop_pending(avr, vector);
    }
}

/* The data sheet says 4 cycles (5 with a 3-byte PC), and 4 more if the CPU slept. simavr says 0. */
static void charge_entry(struct cpu *cpu)
{
    avr_t *avr = cpu->avr;
    avr_cycle_count_t cycles = avr->address_size == 3 ? 5 : 4;
    if (cpu->has_slept) {
        cycles += 4;
    }
    cpu_halt(avr, cycles);
}

static void entered(struct cpu *cpu, uint8_t vector)
{
    if (cpu->depth == 0) {
        cpu->entered = cpu->avr->cycle;
    }
    if (cpu->depth < sizeof(cpu->vectors)) {
        cpu->vectors[cpu->depth++] = vector;
    }
    cpu->latest = cpu->avr->cycle;
    notify(cpu);
    if (cpu->exact) {
        charge_entry(cpu);
    }
    cpu->has_slept = false;
}

/* simavr calls this at RETI, before it adds the cycles of RETI. */
static void left(struct cpu *cpu)
{
    if (cpu->depth && --cpu->depth == 0) {
        cpu->in_handlers += cpu->avr->cycle + 2u + cpu->avr->address_size - cpu->entered;
    }
    notify(cpu);
}

static void running(struct avr_irq_t *irq, uint32_t value, void *param)
{
    if (value) {
        entered(param, (uint8_t)(irq->irq >> 8)); // simavr numbers these IRQs vector * 256 + 1
    } else {
        left(param);
    }
}

void cpu_init(struct cpu *cpu, avr_t *avr, bool exact)
{
    *cpu = (struct cpu){.avr = avr, .exact = exact};
    for (unsigned i = 0; i < avr->interrupts.vector_count; i++) {
        avr_irq_register_notify(avr->interrupts.vector[i]->irq + AVR_INT_IRQ_RUNNING, running, cpu);
    }
}

void cpu_reset(struct cpu *cpu)
{
    cpu->depth = 0;
    cpu->has_slept = false;
    notify(cpu);
}

void cpu_stepped(struct cpu *cpu)
{
    /* After SEI or RETI simavr 1.6 runs two instructions before an interrupt, silicon runs one. */
    if (cpu->exact && cpu->avr->interrupt_state == -1) {
        cpu->avr->interrupt_state = (int8_t)(avr_has_pending_interrupts(cpu->avr) != 0);
    }
}

void cpu_slept(struct cpu *cpu, uint64_t cycles)
{
    if (cpu->exact) {
        cpu->avr->cycle--; // simavr adds 1 + cycles and would wake one cycle late
    }
    cpu->asleep += cycles;
    cpu->has_slept = true;
}
