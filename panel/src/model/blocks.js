// SPDX-License-Identifier: MIT
/* The blocks of registers that the page reads of each servo, and where each value stands in them. */

import { REGISTER } from "../wire/registers.js";

export const FEEDBACK = { address: REGISTER.PRESENT_POSITION, count: 8 };
export const STATE = { address: REGISTER.TORQUE_ENABLE, count: 10 };
export const LIMITS = { address: REGISTER.CW_ANGLE_LIMIT, count: 4 };

export const FEEDBACK_OFFSET = { position: 0, speed: 2, load: 4, voltage: 6, temperature: 7 };
export const STATE_OFFSET = { torque: 0, led: 1, goal: 6, speed: 8 };
export const LIMITS_OFFSET = { low: 0, high: 2 };
