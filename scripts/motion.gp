# SPDX-License-Identifier: MIT
# Draws goal and present position of the servos over time, one row for each servo, from the last data
# block of a CSV that cds55xx-sim --csv wrote. gnuplot -e "csv='FILE'; svg='FILE'; name='TITLE'" motion.gp
set datafile separator comma
set terminal svg size 1100,780 dynamic background rgb 'white' font 'sans-serif,13'
set output svg
stats csv using 1 nooutput
block = STATS_blocks - 1
stats csv index block using 1 nooutput
columns = STATS_columns
start = STATS_min
servos = (columns - 1) / 2
degrees(x) = x * 300.0 / 1023.0
set title name
set xlabel 'time since these servos were switched on (s)'
set ylabel 'servo ID; each row spans 0 to 300 degrees'
set yrange [0.4:servos + 0.6]
set ytics 1
set grid ytics lc rgb '#dddddd'
set key outside top right horizontal
row(i, x) = i - 0.45 + 0.9 * degrees(x) / 300.0
plot for [i=1:servos] csv index block using (($1 - start) / 1000):(row(i, column(2 * i))) \
         with steps lc rgb '#d95f02' lw 1 title (i == 1 ? 'goal position' : ''), \
     for [i=1:servos] csv index block using (($1 - start) / 1000):(row(i, column(2 * i + 1))) \
         with lines lc rgb '#1b6ca8' lw 1.6 title (i == 1 ? 'present position' : '')
