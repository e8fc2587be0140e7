# SPDX-License-Identifier: MIT
# What the hot path costs: make bench.

BENCH_NEEDS := build/host/cds55xx-sim $(BOARDS:%=build/%/controller.elf) $(EXAMPLES) build/atmega644p/benchmark/min.elf \
	$(patsubst %,build/atmega128/benchmark/%.elf,read prepared noisy sync group absent handlers polls two_mbps cycle8 motion gait \
	safe_read safe_calls safe_torque_off turnaround) \
	$(patsubst %,build/%/benchmark/handlers.elf,arduino-mega arbotix) build/arduino-mega/benchmark/motion.elf \
	$(patsubst %,build/atmega128/firmware/%.elf,cycle50 cycle50_safe flood) build/arduino-mega/firmware/three_buses.elf

## bench: what the hot path costs, in cycles, beside limits and goals; build/bench.tsv
.PHONY: bench
# nice: it may run beside tests that wait in real time (.ci/run); cycles of the simulator do not depend on it.
bench: $(BENCH_NEEDS)
	$(clear)
	@nice scripts/bench.py

## bench-scaling: how the cost grows from 1 to 50 servos; build/bench-scaling.tsv and .svg
.PHONY: bench-scaling
bench-scaling: $(BENCH_NEEDS)
	$(clear)
	@scripts/bench.py --scaling

## bench-account: where the cycles of make bench go, function by function
.PHONY: bench-account
bench-account: $(BENCH_NEEDS)
	$(clear)
	@scripts/account.py

## bench-docs: make bench, and renew its tables in README.md and docs/internals/performance.md
.PHONY: bench-docs
bench-docs: $(BENCH_NEEDS)
	$(clear)
	-@scripts/bench.py # a figure above its limit does not keep the tables from being renewed
	@scripts/bench.py --docs && scripts/account.py --docs

## bench-ci: make bench, a tenth of it again, the same to the digit, its tables up to date
.PHONY: bench-ci bench-again bench-documents
bench-ci: bench-again bench-documents
bench-again: bench
	@nice scripts/bench.py --again 1/10 --seed $(or $(SEED),0)
bench-documents: bench
	@nice scripts/bench.py --docs --check; bench=$$?; nice scripts/account.py --docs --check && exit $$bench
