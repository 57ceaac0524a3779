# What the cases of messages.txt find in their folder, beside block.toml. $TUMBLE is the program.
set -e
cp block.toml ball.toml
cp block.toml ...toml
printf 'titel = "x"\n' >bad.toml
printf '\377\376' >not_text.toml
printf 'one\n' >text.h5
mkdir folder.toml empty empty_runs
"$TUMBLE" run block.toml --size 32x18 --duration 0.1 --quiet
"$TUMBLE" run ball.toml --size 32x18 --duration 0.1 --time-step 0.002 --quiet
"$TUMBLE" run block.toml --size 32x18 --duration 0.1 --frames 0:1 --out slice --quiet
"$TUMBLE" baseline update block.toml --size 32x18 --quiet
head -c 60000 out/block/trajectory.h5 >short.h5
cp out/block/frames/frame_000000.png a.png
cp out/block/frames/frame_000001.png b.png
cp -r out/block damaged
mkdir ball && cp out/block/trajectory.h5 ball/trajectory.h5
printf 'no picture' >text.png
printf 'no picture' >damaged/frames/frame_000001.png
head -c 200 a.png >short.png
"$TUMBLE" run block.toml --size 16x9 --duration 0.05 --out other --no-video --quiet
cp other/block/frames/frame_000000.png small.png
printf '[1]' >list.json
printf '{"windows": 3}' >gate.json
printf '{"edge shift": -3}' >value.json
printf 'v 0 0 0\nv 1 0 zero\n' >word.obj
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n' >flat.obj
hull='[[body]]\nname = "rock"\nshape = { kind = "hull", file = "%s" }\ndensity = 1000\n'
printf "$hull" word.obj >word.toml
printf "$hull" flat.obj >flat.toml
printf "$hull" none.obj >none.toml
cp -r baselines damaged_baselines
printf '{' >damaged_baselines/block/common/baseline.json
printf '{' >damaged_run.json
cp -r out/block damaged_run && cp damaged_run.json damaged_run/frames/run.json
mkdir galleries galleries/block && printf '{' >galleries/block/summary.json
mkdir damaged_resume && cp -r damaged_run damaged_resume/block
printf 'v 0 0 \0 0\n' >zero.obj
printf "$hull" zero.obj >zero.toml
head -c 1500 out/block/block.mp4 >short.mp4
"$TUMBLE" simulate block.toml --out stopped --duration 10000 --checkpoint 0 --quiet & process=$!
until [ -e stopped/block/checkpoint.bin ]; do sleep 0.02; done
kill -KILL $process; wait $process || true
