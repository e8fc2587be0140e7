// SPDX-License-Identifier: MIT
/* In the page: the rows of a table that tables.mjs has packed. */

const VALUES = { "#": Number, "?": Boolean, "*": (text) => text.split(" ") };

/* A table is lines: the names of the fields, then a line for each field with its values of all rows. The first character
 * of a name: # number, ? true or false, * list of words, - text that a row may lack, = text. */
export function unpacked(text) {
    const [names, ...columns] = text.split("\n").map((line) => line.split("~"));
    const fieldOf = (row) => (name, index) => {
        const value = columns[index][row];

        return name[0] === "-" && !value ? [] : [[name.slice(1), VALUES[name[0]]?.(value) ?? value]];
    };

    return columns[0].map((_, row) => Object.fromEntries(names.flatMap(fieldOf(row))));
}

/* An object with a row for each value of the field `number`. */
export const byNumber = (rows) => Object.fromEntries(rows.map(({ number, ...row }) => [number, row]));
