# SPDX-License-Identifier: MIT
# Draws build/bench-scaling.tsv: how the cost grows with the number of servos. Upper row: measured time
# and the floor of the wire. Lower row: the time above the floor, for each servo.
# gnuplot -e "table='FILE'; output_file='FILE'" bench.gp
set encoding utf8
set datafile separator tab
if (!exists('picture_size')) picture_size = '1180,700'
if (!exists('terminal_name')) terminal_name = "svg dynamic background rgb 'white' font 'sans-serif,13'"
set terminal @terminal_name size @picture_size
set output output_file
set multiplot layout 2,3 margins 0.07,0.98,0.09,0.93 spacing 0.07,0.13
set grid xtics ytics lt 1 lw 1 lc rgb '#dddddd'
set xrange [0:52]
set xtics (1, 5, 10, 20, 30, 50)
set yrange [0:*]
set key top left reverse Left
names = 'read sync cycle'
title(name) = name eq 'read' ? 'read: feedback of all, 8 bytes each' : \
              name eq 'sync' ? 'sync: goals of all, built and sent' : \
                               'cycle: all read once, goals at 250 Hz'
mine(name, position) = strcol(1) eq name ? column(position) : NaN
do for [name in names] {
    set title title(name)
    unset xlabel
    set ylabel (name eq 'read' ? 'time (ms)' : '')
    plot table using 2:(mine(name, 3) / 1000) with linespoints lc rgb '#1b6ca8' lw 2 pt 7 ps 0.7 \
               title 'measured', \
         table using 2:(mine(name, 5) / 1000) with lines lc rgb '#d95f02' lw 2 dt 2 \
               title 'floor of the wire'
}
unset title
do for [name in names] {
    set xlabel 'servos on the bus'
    set ylabel (name eq 'read' ? 'over the floor (µs a servo)' : '')
    plot table using 2:((mine(name, 3) - column(5)) / column(2)) with linespoints \
               lc rgb '#1b6ca8' lw 2 pt 7 ps 0.7 notitle
}
unset multiplot
