// SPDX-License-Identifier: MIT
/* The blocks of registers that the page reads of each servo, and where each value stands in them. */

import { REGISTER } from "../wire/registers.js";

export const FEEDBACK = Object.freeze({ address: REGISTER.PRESENT_POSITION, count: 8 });
export const STATE = Object.freeze({ address: REGISTER.TORQUE_ENABLE, count: 10 });
export const LIMITS = Object.freeze({ address: REGISTER.CW_ANGLE_LIMIT, count: 4 });

export const FEEDBACK_OFFSET = Object.freeze({ position: 0, speed: 2, load: 4, voltage: 6, temperature: 7 });
export const STATE_OFFSET = Object.freeze({ torque: 0, led: 1, goal: 6, speed: 8 });
export const LIMITS_OFFSET = Object.freeze({ low: 0, high: 2 });
