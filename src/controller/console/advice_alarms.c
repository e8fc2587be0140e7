/* SPDX-License-Identifier: MIT */
/* Remedies of alarms; see advice_alarms.h. */
#include "console/advice_alarms.h"

#include <stdbool.h>

#include "cds55xx/packet.h" // CDS_ERROR_*
#include "console/console.h"
#include "console/messages.h"
#include "console/reply.h" // reply_remedy()

/* Of alarms, behind their condition. */
static const CDS_FLASH char message_may_be_damaged[] =
    "; bytes on the line may be damaged, by noise or a loose plug: 'diagnose %u'";
static const CDS_FLASH char message_offline_damaged[] =
    "; check power, wiring, ID and baud rate of the servo; packets came damaged since the last "
    "'clear', by noise or a loose plug: 'diagnose %u'";
static const CDS_FLASH char message_stays_off[] =
    "; torque stays off: 'servos' tells why; mend power, load, plug or heat, '%s', then "
    "'teach off ID' holds it where it is";

/* True if a servo has received a damaged packet since the last `clear`. The counters go back to the
 * reset: they may be of a fault that is over. */
static bool has_damage(const struct console *console)
{
    return console->robot->servos.alarms & CDS_ERROR_CHECKSUM;
}

/* True if the remedy of lost torque was told of another servo, which has not been released. */
static bool loss_was_told(const struct console *console)
{
    const struct cds_servos *servos = &console->robot->servos;

    for (uint8_t i = 0; i < servos->count; i++)
        if (i != console->failsafe->next && servos->states[i].inhibits & CDS_INHIBIT_STATE_LOST &&
            servos->states[i].held & CDS_HELD_LOSS_TOLD)
            return true;
    return false;
}

/* True if the remedy of damaged bytes was told since the last `clear`. Each checksum error that is
 * told has it. An instruction error may have another one; `bit` is that of the alarm. */
static bool damage_was_told(const struct console *console, uint8_t bit)
{
    const struct failsafe *failsafe = console->failsafe;

    for (uint8_t i = 0; i < console->robot->servos.count; i++)
        if (failsafe->reported[i] & CDS_ERROR_CHECKSUM &&
            (i != failsafe->next || bit != CDS_ERROR_CHECKSUM))
            return true;
    return false;
}

/* What to do about torque that went off by itself. While the host link is lost, `release` is
 * refused: `clear` ends both inhibits. */
static const CDS_FLASH char *remedy_of_loss(struct console *console)
{
    console->printer.values[4].text =
        console->failsafe->link_lost ? message_clear : message_release;
    return loss_was_told(console) ? message_nothing : message_stays_off;
}

const CDS_FLASH char *advice_alarm_remedy(struct console *console, uint8_t condition)
{
    uint8_t bit = (uint8_t)(1u << condition);

    if (!console_is_for_person(console))
        return reply_remedy(condition);
    if (condition == REPLY_TORQUE_LOST)
        return remedy_of_loss(console);
    console->printer.values[4].number = console->failsafe->alarm_id;
    if (!has_damage(console))
        return reply_remedy(condition);
    if (condition == REPLY_OFFLINE)
        return message_offline_damaged;
    if (!(bit & (CDS_ERROR_CHECKSUM | CDS_ERROR_INSTRUCTION)))
        return reply_remedy(condition);
    return damage_was_told(console, bit) ? message_nothing : message_may_be_damaged;
}

void advice_note_refused(struct console *console, uint8_t error)
{
    struct failsafe *failsafe = console->failsafe;
    const struct cds_servo_state *servo = console_servo(console);
    uint8_t bit = 0;

    for (uint8_t i = 0; i < REPLY_TORQUE_LOST; i++)
        if (reply_remedy_error(i) == error)
            bit = (uint8_t)(1u << i);
    if (!servo || !(bit & (uint8_t)~CDS_ERRORS_OF_CONDITION) || !console_is_for_person(console))
        return;
    failsafe->reported[servo - console->robot->states] |= bit;
    if (failsafe->alarm_id == servo->id)
        failsafe->alarm &= (uint8_t)~bit;
}
