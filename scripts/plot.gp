# SPDX-License-Identifier: MIT
# The picture of a run, from the data files that sim/output/plot_drawing.c writes into a folder:
# gnuplot -e "folder='...'" plot.gp
# First pane: a lane for each talker. Behind it: positions of the servos, and on request speed and load.
load folder.'/params.gp'

# of each layer of sim/output/plot_drawing.c: what it is, colour, point type (0: a bar), point size
styles = "controller servo bin1 bin10 bin50 bin100 fault collision breach damaged"
array label[10] = ['packet of the '.talker, 'packet of a servo', 'up to 1 %', 'to 10 %', \
    'to 50 %', 'to 100 %', 'fault injected', 'collision', 'rule broken', 'no packet']
array colour[10] = ['#1b6ca8', '#d95f02', '#9ecae1', '#4292c6', '#08519c', '#041f4a', \
    '#7b3294', '#d7191c', '#000000', '#e08214']
array point[10] = [0, 0, 0, 0, 0, 0, 13, 9, 2, 6]
array size[10] = [0, 0, 0, 0, 0, 0, 0.8, 0.9, 0.9, 1.6]
style(layer) = sum [i=1:10] (word(styles, i) eq layer ? i : 0)

# pixels; the title of a pane and its legend stand one above the other
longest = 0
do for [i=1:lanes] { longest = strlen(lane[i]) > longest ? strlen(lane[i]) : longest }
left = longest > 16 ? 10 + 7 * longest : 118
right = 25; head = 96; between = 122; foot = 60
title_above = 42; legend_above = 18
row_height = lanes <= 10 ? 26 : lanes <= 25 ? 18 : 14
together = servos <= overlaid
upper = lanes * row_height
lower = together ? 320 : servos * 24
total_width = left + width + right
total = head + upper + (between + lower) * words(panes) + foot
x(pixels) = pixels * 1.0 / total_width
y(pixels) = 1 - pixels * 1.0 / total

set encoding utf8
set terminal svg size total_width,total fixed background rgb 'white' font 'sans-serif,12' noenhanced
set output svg
set multiplot
set lmargin at screen x(left)
set rmargin at screen x(left + width)
set xrange [0:end]
set tics nomirror out
set border 3 lc rgb '#444444'
set style fill solid noborder
set label 1 name at screen x(left), y(18) left font ',15'
binned = strstrt(layers, 'bin') > 0

# ---- the sender at each time ----
set tmargin at screen y(head)
set bmargin at screen y(head + upper)
set yrange [0.5:lanes + 0.5]
set ytics scale 0 font ','.(row_height < 18 ? 10 : 12)
set ytics ('' 0)
do for [i=1:lanes] { set ytics add (lane[i] lanes + 1 - i) }
set grid xtics lc rgb '#e4e4e4' lt 1
do for [i=0:lanes] { set arrow i+1 from graph 0, first i + 0.5 to graph 1, first i + 0.5 nohead \
    lc rgb '#eeeeee' back }
set xlabel 'time ('.unit.')' offset 0,0.3
set label 2 'Senders on the bus'.(binned ? ': share of every '.bin : '') \
    at screen x(left), y(head - title_above) left
set key at screen x(left + width), y(head - legend_above) right center horizontal samplen 1.5 \
    font ',11' noautotitle
file(i) = folder.'/'.word(layers, i)
s(i) = style(word(layers, i))
commands = 'NaN'
do for [i=1:words(layers)] {
    n = s(i)
    what = point[n] == 0 \
        ? sprintf("using (($1 + $2) / 2):3:1:2:($3 - 0.38):($3 + 0.38) with boxxyerror") \
        : sprintf("using 1:2 with points pt %d ps %.1f lw 1.5", point[n], size[n])
    commands = commands.sprintf(", file(%d) %s lc rgb colour[%d] title label[%d]", i, what, n, n)
}
eval 'plot '.commands

# ---- where the servos are, how fast they are, what load they carry ----
array hue[6] = ['#1b6ca8', '#d95f02', '#1b9e77', '#7b3294', '#a6761d', '#e7298a']
what_is(pane) = pane eq 'position' ? 'Where the servos are' : \
    pane eq 'speed' ? 'Present speed (CCW is positive)' : \
    'Present load (CCW is positive)'
row_of(pane) = pane eq 'position' ? ': each row spans 0 to 300 degrees' : \
    pane eq 'speed' ? ': each row spans -62 to 62 RPM' : ': each row spans -100 to 100 % of the stall torque'
axis_of(pane) = pane eq 'position' ? 'position (degrees)' : \
    pane eq 'speed' ? 'speed (RPM)' : 'load (% of the stall torque)'
lowest(pane) = pane eq 'position' ? 0 : pane eq 'speed' ? -62 : -100
highest(pane) = pane eq 'position' ? 300 : pane eq 'speed' ? 62 : 100
step(pane) = pane eq 'position' ? 60 : pane eq 'speed' ? 31 : 50
samples = folder.'/samples'
goal_dash = together ? 2 : 1
y_of(i, v) = together ? v : servos - i + 0.54 + 0.92 * (v - low) / (high - low)
unset label 1
unset label 2
do for [p=1:words(panes)] {
    pane = word(panes, p)
    low = lowest(pane); high = highest(pane)
    top = head + upper + between + (p - 1) * (lower + between)
    unset arrow
    set tmargin at screen y(top)
    set bmargin at screen y(top + lower)
    set key at screen x(left + width), y(top - legend_above) right center horizontal samplen 2 font ',11' \
        noautotitle
    set label 3 what_is(pane).(together ? '' : row_of(pane)) at screen x(left), y(top - title_above) left
    if (together) {
        set yrange [low:high]
        set ytics low,step(pane),high scale 1 font ',12'
        set grid ytics lc rgb '#e4e4e4' lt 1
        set ylabel axis_of(pane)
    } else {
        set yrange [0.5:servos + 0.5]
        set ytics ('' 0) scale 0 font ',10'
        do for [i=1:servos] { set ytics add (servo[i] servos + 1 - i) }
        unset ylabel
        do for [i=0:servos] { set arrow i+1 from graph 0, first i + 0.5 to graph 1, first i + 0.5 \
            nohead lc rgb '#dddddd' back }
    }
    if (pane eq 'position') {
        plot NaN, \
            for [i=1:servos] samples index i-1 using 1:(y_of(i, $2)) with steps lw 1.2 \
                dt goal_dash lc rgb (together ? hue[i] : '#d95f02'), \
            for [i=1:servos] samples index i-1 using 1:(y_of(i, $3)) with lines lw 1.6 \
                lc rgb (together ? hue[i] : '#1b6ca8') title (together ? servo[i] : ''), \
            keyentry with lines lw 1.2 dt goal_dash lc rgb (together ? '#444444' : '#d95f02') \
                title 'goal position', \
            keyentry with lines lw 1.6 lc rgb (together ? '#444444' : '#1b6ca8') \
                title 'present position'
    } else {
        plot for [i=1:servos] y_of(i, 0) with lines lw 1 lc rgb '#cccccc', \
            for [i=1:servos] samples index i-1 using 1:(y_of(i, column(pane eq 'speed' ? 4 : 5))) \
                with lines lw 1.4 lc rgb (together ? hue[i] : '#1b6ca8') \
                title (together ? servo[i] : '')
    }
}
unset multiplot
