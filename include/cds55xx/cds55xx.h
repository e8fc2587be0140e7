/* SPDX-License-Identifier: MIT */
/* The one include that is enough for a robot: all of the library's headers but those of the port
 * (port.h, link.h) and of its parts (parser.h, ring.h), which bus.h includes. A program pays only
 * for what it calls. */
#ifndef CDS55XX_H
#define CDS55XX_H

#include "cds55xx/blocking.h"        // calls that wait; scan, identity, setup, diagnose, group_read
#include "cds55xx/control_table.h"   // CDS_REG_*
#include "cds55xx/cycle.h"           // goals and feedback at a fixed rate
#include "cds55xx/feedback.h"        // all that a servo reports
#include "cds55xx/follow.h"          // a joint that does not follow its goals
#include "cds55xx/gait.h"            // joints that swing: a walking robot
#include "cds55xx/health.h"          // state check beside the application
#include "cds55xx/motion.h"          // timed moves of poses
#include "cds55xx/pose.h"            // mirror poses, add offsets
#include "cds55xx/queue.h"           // requests that wait; retries
#include "cds55xx/registered_move.h" // all servos start at once
#include "cds55xx/robot.h"           // the one object most programs need
#include "cds55xx/sequence.h"        // poses, step after step
#include "cds55xx/servo.h"           // one servo
#include "cds55xx/servo_units.h"     // one servo, in units
#include "cds55xx/servos.h"          // what is known of each servo, limits, inhibits
#include "cds55xx/sync_write.h"      // many servos in one packet
#include "cds55xx/torque_off.h"      // torque off for all, verified
#include "cds55xx/torque_on.h"       // torque on without a movement
#include "cds55xx/version.h"         // version of the library

#endif
