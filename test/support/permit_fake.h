/* SPDX-License-Identifier: MIT */
/* Hooks of a bus whose permit the test provides. The bus asks it when a request is submitted and
 * before the packet leaves, as it asks the permit of servos.h. A queue does the rest. */
#ifndef PERMIT_FAKE_H
#define PERMIT_FAKE_H

#include "cds55xx/queue.h"
#include "unity.h"

typedef enum cds_result permit_fake_answer(struct cds_request *request);

static struct {
    permit_fake_answer *answer;
    struct cds_queue queue;
    struct cds_bus_hooks hooks;
} permit_fake;

static enum cds_result permit_fake_permit(void *context, struct cds_request *request)
{
    (void)context;
    request->return_delay_us = permit_fake.queue.bus->return_delay_us;
    request->is_muted = false;
    return permit_fake.answer(request);
}

static enum cds_result permit_fake_submit(void *context, struct cds_request *request)
{
    enum cds_result result = permit_fake_permit(context, request);

    return result == CDS_OK ? permit_fake.queue.hooks.submit(context, request) : result;
}

static inline void permit_fake_attach(struct cds_bus *bus, permit_fake_answer *answer)
{
    cds_queue_begin(&permit_fake.queue, bus);
    permit_fake.answer = answer;
    permit_fake.hooks = permit_fake.queue.hooks;
    permit_fake.hooks.permit = permit_fake_permit;
    permit_fake.hooks.submit = permit_fake_submit;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_attach(bus, &permit_fake.hooks));
}

#endif
