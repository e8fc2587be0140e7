/* SPDX-License-Identifier: MIT */
/* The sine in real numbers for tests, which link no libm. */
#ifndef REAL_SINE_H
#define REAL_SINE_H

/* Returns the sine of `turn` turns, 0 or more, by its series. */
static inline double real_sine(double turn)
{
    double x, term, sum;

    turn -= (double)(long)turn;
    if (turn > 0.25)
        turn = turn < 0.75 ? 0.5 - turn : turn - 1;
    x = 2 * 3.14159265358979323 * turn;
    sum = term = x;
    for (int i = 2; i < 20; i += 2) {
        term *= -x * x / (i * (i + 1));
        sum += term;
    }
    return sum;
}

#endif
