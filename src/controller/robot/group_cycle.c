/* SPDX-License-Identifier: MIT */
/* The cycle of the group; see group_cycle.h. */
#include "robot/group_cycle.h"

#include <string.h>

enum cds_result group_cycle_begin(struct robot *robot, const void *config)
{
    union robot_work *work = &robot->work;
    enum cds_result result;

    memset(work, 0, sizeof *work);
    result = cds_cycle_begin(&work->cycle.cycle,
                             &(struct cds_cycle_config){.bus = robot->bus,
                                                        .ids = robot->group,
                                                        .packets = work->cycle.packets,
                                                        .feedback = work->cycle.feedback,
                                                        .count = robot->group_count,
                                                        .period_us = *(const uint16_t *)config});
    if (result == CDS_OK)
        robot_share_bus(robot, &work->cycle.cycle);
    return result;
}

enum cds_result group_cycle_poll(struct robot *robot)
{
    return cds_cycle_poll(&robot->work.cycle.cycle);
}

void group_cycle_abort(struct robot *robot)
{
    cds_cycle_abort(&robot->work.cycle.cycle);
}

const CDS_FLASH struct robot_operation group_cycle = {
    .begin = group_cycle_begin, .poll = group_cycle_poll, .abort = group_cycle_abort};

enum cds_result group_cycle_await_positions(const struct robot *robot, uint32_t begun_us)
{
    const struct cds_feedback *feedback = robot->work.cycle.feedback;

    for (uint8_t left = robot->group_count; left; left--, feedback++) {
        if (feedback->known)
            continue;
        if (cds_port_now_us() - begun_us > GROUP_CYCLE_KNOWN_US)
            return (enum cds_result)feedback->result;
        return CDS_PENDING;
    }
    return CDS_OK;
}
