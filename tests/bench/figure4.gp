# Figure 4 of Bender & Schmitt 2006, remade: time of each phase against what it solves, every step a point.
# gnuplot -e "dir='out/bench'" figure4.gp    reads steps.csv, writes figure4.svg, figure4.png and figure4.txt.
set datafile separator ','
steps = dir.'/steps.csv'
ours(x) = (strcol(1) eq 'tumble') ? x : NaN
collision(x) = a * x
contact(x) = b * x
a = 0.001
b = 0.0001
set fit quiet logfile '/dev/null'
fit collision(x) steps using (ours($5) > 0 ? $5 : NaN):7 via a
fit contact(x) steps using (ours($4) > 0 ? $4 : NaN):8 via b
set print dir.'/figure4.txt'
print sprintf('collision phase: %.5f ms a collision  (the paper: 0.075 on a 3.4 GHz Pentium 4)', a)
print sprintf('contact phase:   %.5f ms a contact    (the paper: 0.015)', b)
unset print
set key top left
set grid
do for [kind in 'svg png'] {
    if (kind eq 'svg') { set terminal svg size 1000,420 font 'sans,12' background 'white' }
    if (kind eq 'png') { set terminal pngcairo size 1000,420 font 'sans,10' }
    set output dir.'/figure4.'.kind
    set multiplot layout 1,2
    set xlabel 'collisions in the step'
    set ylabel 'collision phase [ms]'
    plot steps using (ours($5)):7 with points pt 7 ps 0.3 lc rgb '#2274a5' title 'a step', \
         collision(x) lw 2 lc rgb '#c8102e' title sprintf('%.4f ms each', a), \
         0.075 * x lw 1 dt 2 lc rgb 'black' title 'the paper: 0.075 ms each'
    set xlabel 'contacts in the step'
    set ylabel 'contact phase [ms]'
    plot steps using (ours($4)):8 with points pt 7 ps 0.3 lc rgb '#2274a5' title 'a step', \
         contact(x) lw 2 lc rgb '#c8102e' title sprintf('%.5f ms each', b), \
         0.015 * x lw 1 dt 2 lc rgb 'black' title 'the paper: 0.015 ms each'
    unset multiplot
    unset output
}
