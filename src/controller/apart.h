/* A function that is not to be melted into its caller: smaller where the caller would compute the
 * place of what it works on again and again, or where there are several callers. Not for what runs
 * often. */
#ifndef CONTROLLER_APART_H
#define CONTROLLER_APART_H

#define APART __attribute__((noinline))

#endif
