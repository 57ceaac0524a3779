/// Films and studies on a cluster: a real controller and two real nodes on this machine, of the test's own
/// (tests/tools/cluster.sh), and what goes wrong there.
#include "tests/program/program_fixture.h"

#include <regex>
#include <sstream>
#include <vector>

using test::expect_one_line;
using test::Outcome;
namespace fs = std::filesystem;

namespace {

class slurm : public test::Program {
protected:
    void SetUp() override {
        Program::SetUp();
        if (shell("PATH=$PATH:/usr/sbin; command -v slurmctld slurmd munged sbatch").code != 0) {
            GTEST_SKIP() << "no Slurm (Debian: slurmctld, slurmd, slurm-client, munge)";
        }
        // Its nodes make sockets, whose names must be short.
        const Outcome started =
            shell("ln -s $(mktemp -d /tmp/tumble-cluster.XXXXXX) cluster; " + cluster + " start cluster");
        ASSERT_EQ(started.code, 0) << started.err;
    }
    void TearDown() override {
        if (fs::exists(folder / "cluster")) {
            shell("SLURM_CONF=$PWD/cluster/slurm.conf scancel --user=$(id -un) 2>/dev/null; " + cluster +
                  " stop cluster; rm -rf $(readlink cluster) cluster");
        }
    }

    /// Shell commands that talk to the cluster.
    Outcome on_cluster(const std::string& commands) const {
        return shell("export SLURM_CONF=$PWD/cluster/slurm.conf\n" + commands);
    }
    Outcome run_on_cluster(const std::string& arguments) const {
        return on_cluster("timeout 100 \"$TUMBLE\" " + arguments);
    }

    /// Frames, film and trajectory; of frames that differ it is told by how much.
    void expect_same_results(const std::string& a, const std::string& b) const {
        for (const std::string& name : files_in(a)) {
            if (name.ends_with(".png") || name.ends_with(".mp4") || name.ends_with(".h5")) {
                ASSERT_TRUE(fs::exists(folder / b / name)) << name;
                EXPECT_TRUE(bytes(a + "/" + name) == bytes(b + "/" + name))
                    << name << "\n"
                    << (name.ends_with(".png")
                            ? tumble("compare '" + a + "/" + name + "' '" + b + "/" + name + "'").out
                            : "");
            }
        }
    }

    const std::string cluster = "'" TUMBLE_SOURCE_DIR "/tests/tools/cluster.sh'";
    /// As long as several polls of Slurm's controller.
    const std::string slow =
        "run block.toml --size 1920x1080 --duration 2 --set output.subframes=16 --set output.shutter=0.5 ";
};

/// study.csv without what was measured: processor time.
std::string without_costs(const std::string& csv) {
    std::string text;
    std::istringstream lines(csv);
    std::vector<bool> is_kept;
    for (std::string line; std::getline(lines, line);) {
        std::istringstream cells(line);
        std::size_t column = 0;
        const bool is_title = is_kept.empty();
        for (std::string cell; std::getline(cells, cell, ','); ++column) {
            if (is_title) {
                is_kept.push_back(cell.find("cost") == std::string::npos &&
                                  cell.find("cpu") == std::string::npos &&
                                  cell.find("front") == std::string::npos);
            }
            text += column < is_kept.size() && is_kept[column] ? cell + "," : "";
        }
        text += "\n";
    }
    return text;
}

} // namespace

TEST_F(slurm, films_and_studies_are_those_of_one_machine) {
    ASSERT_EQ(shell("sed 's/0.9/1.1/' block.toml >other.toml").code, 0);
    ASSERT_EQ(tumble("run block.toml other.toml --preset draft --poster 0.1 --quiet --out here").code, 0);
    const std::string run =
        "run block.toml other.toml --preset draft --on slurm --slices 3 --out 'all of %a' ";
    const Outcome outcome = run_on_cluster(run + "--poster 0.1");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "block: 8 frames; in all of %a/block\nother: 8 frames; in all of %a/other\n");
    expect_same_results("here", "all of %a");
    // Nothing is left to do, and a frame that is lost is drawn again; with the film goes a poster that is not
    // asked for.
    fs::remove(folder / "here/block/block_poster.png");
    fs::remove(folder / "here/other/other_poster.png");
    const std::string submitted = bytes("all of %a/block/slurm/jobs");
    fs::remove(folder / "all of %a/other/frames/frame_000002.png");
    ASSERT_EQ(run_on_cluster(run + "--quiet").code, 0);
    expect_same_results("here", "all of %a");
    EXPECT_EQ(bytes("all of %a/block/slurm/jobs"), submitted);
    // By hand, without Slurm.
    fs::remove(folder / "all of %a/block/frames/frame_000000.png");
    EXPECT_EQ(shell("sh 'all of %a/block/slurm/draw.sh' 0 && sh 'all of %a/block/slurm/join.sh'").code, 0);
    expect_same_results("here", "all of %a");

    ASSERT_EQ(tumble("render here/block/trajectory.h5 --size 64x36 --out small --quiet").code, 0);
    ASSERT_EQ(
        run_on_cluster("render here/block/trajectory.h5 --size 64x36 --out again --on slurm --quiet").code,
        0);
    expect_same_results("small", "again");

    const std::string study = "study block.toml --knobs 'time step' --no-film --quiet ";
    ASSERT_EQ(tumble(study + "--out study_here").code, 0);
    const Outcome studied = run_on_cluster(study + "--out study_there --on slurm");
    ASSERT_EQ(studied.code, 0) << studied.err;
    EXPECT_EQ(without_costs(bytes("study_here/block/study.csv")),
              without_costs(bytes("study_there/block/study.csv")));
}

TEST_F(slurm, checks_of_baselines_are_those_of_one_machine) {
    ASSERT_EQ(shell("sed 's/0.9/1.1/' block.toml >other.toml").code, 0);
    ASSERT_EQ(tumble("baseline update block.toml other.toml --size 64x36 --quiet").code, 0);
    const std::string check = "baseline check --on slurm ";
    const Outcome same = run_on_cluster(check);
    EXPECT_EQ(same.code, 0) << same.err;
    EXPECT_NE(same.out.find("2 cases: 2 identical"), std::string::npos) << same.out;

    // A scene that changed, and one that stops: told as without a cluster.
    ASSERT_EQ(
        shell("sed -i 's/0.9/2.5/' block.toml; sed -i 's/density = 1000/density = -1/' other.toml").code, 0);
    const Outcome here = tumble("baseline check --report here");
    const Outcome there = run_on_cluster(check + "--report there");
    EXPECT_EQ(there.code, here.code) << there.err;
    EXPECT_EQ(std::regex_replace(there.out, std::regex("there"), "here"), here.out);
    EXPECT_EQ(files_in("here").size(), files_in("there").size() - 8)
        << "scripts, jobs, two logs and exit codes, and why a scene has no pictures";

    // Left alone, then gone on with: what was drawn is compared, and drawn anew by the next check only.
    const Outcome left = run_on_cluster(check + "block.toml --report left --detach");
    EXPECT_EQ(left.code, 0) << left.err;
    EXPECT_EQ(left.out.rfind("baselines, draw: job ", 0), 0u) << left.out;
    const std::string jobs = bytes("left/slurm/jobs");
    EXPECT_EQ(run_on_cluster(check + "block.toml --report left --quiet").code, 1);
    EXPECT_EQ(bytes("left/slurm/jobs"), jobs);
    EXPECT_EQ(run_on_cluster(check + "block.toml --report left --quiet").code, 1);
    EXPECT_NE(bytes("left/slurm/jobs"), jobs);
}

TEST_F(slurm, a_node_that_dies_costs_no_frame) {
    ASSERT_EQ(tumble(slow + "--quiet --out here").code, 0);
    const Outcome outcome = on_cluster(
        "timeout 250 \"$TUMBLE\" " + slow +
        "--on slurm --slices 4 --quiet & process=$!\n"
        "until [ -e out/block/frames/frame_000002.png ] && [ \"$(squeue -h -t running -w node1)\" ]; do\n"
        "sleep 0.05; done\n" +
        cluster +
        " kill cluster 1\n"
        "wait $process; code=$?\n"
        "timeout 60 sh -c 'until scontrol -o show job >jobs; do sleep 0.2; done'\n"
        "grep -o 'Restarts=[1-9]' jobs | head -1; exit $code");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "Restarts=1\n") << outcome.err << bytes("jobs");
    expect_same_results("here", "out");
}

TEST_F(slurm, the_first_task_that_fails_is_told_with_its_code_and_log) {
    const std::string run = "run block.toml --on slurm --slices 2 ";
    ASSERT_EQ(run_on_cluster(run + "--quiet").code, 0);
    fs::remove(folder / "out/block/frames/frame_000007.png");
    const Outcome other = on_cluster("GALLIUM_OVERRIDE_CPU_CAPS=sse4.1 \"$TUMBLE\" " + run +
                                     "--quiet --slurm --nodelist=node2");
    EXPECT_EQ(other.code, 2) << other.err;
    expect_one_line(other.err);
    EXPECT_TRUE(other.err.starts_with("tumble: block, draw-1 (job ")) << other.err;
    EXPECT_NE(other.err.find("the processor of node2 is x86-64, no more than sse4.1, of node"),
              std::string::npos)
        << other.err;
    EXPECT_NE(other.err.find("--portable"), std::string::npos);
    EXPECT_NE(other.err.find("--slurm --constraint="), std::string::npos);

    // A scene that stops: the jobs that wait for it go.
    const Outcome stops =
        on_cluster("\"$TUMBLE\" run block.toml --out stops --on slurm --slices 2 --duration 1 --quiet "
                   "--strict --set simulation.iteration_limit=1 "
                   "--set simulation.velocity_tolerance=1e-12; code=$?\nsqueue -h; exit $code");
    EXPECT_EQ(stops.code, 5) << stops.err;
    EXPECT_EQ(stops.out, "") << "nothing is left in the queue";
    EXPECT_TRUE(stops.err.starts_with("tumble: block, simulate (job ")) << stops.err;
    EXPECT_NE(stops.err.find("did not converge"), std::string::npos) << stops.err;
    EXPECT_NE(stops.err.find("; log: stops/block/slurm/simulate.log"), std::string::npos) << stops.err;
    expect_one_line(stops.err);

    // Slurm hands limits on to its tasks: frames are larger than that, the trajectory is not.
    const Outcome full =
        on_cluster("ulimit -f 150; \"$TUMBLE\" run block.toml --on slurm --quiet --slices 2 --size "
                   "1280x720 --out full");
    EXPECT_EQ(full.code, 3);
    EXPECT_NE(full.err.find("block, draw-0 (job "), std::string::npos) << full.err;
    EXPECT_NE(full.err.find("cannot write full/block/frames/frame_000000.png"), std::string::npos)
        << full.err;
    EXPECT_NE(full.err.find("; log: full/block/slurm/draw-0.log"), std::string::npos) << full.err;
    EXPECT_TRUE(fs::exists(folder / "full/block/trajectory.h5")) << "what is whole is kept";
}

TEST_F(slurm, jobs_that_are_cancelled_or_left_alone_are_gone_on_with) {
    ASSERT_EQ(tumble(slow + "--quiet --out here").code, 0);
    const std::string command = slow + "--on slurm --slices 6 ";
    const Outcome cancelled =
        on_cluster("timeout 100 \"$TUMBLE\" " + command +
                   "--quiet & process=$!\n"
                   "until [ $(ls out/block/frames 2>/dev/null | wc -l) -gt 4 ]; do sleep 0.1; done\n"
                   "scancel $(sed -n 's/draw //p' out/block/slurm/jobs); wait $process");
    EXPECT_EQ(cancelled.code, 3);
    EXPECT_NE(cancelled.err.find("ended without an exit code: CANCELLED"), std::string::npos)
        << cancelled.err;
    expect_one_line(cancelled.err);

    const Outcome interrupted = on_cluster("timeout 100 \"$TUMBLE\" " + command +
                                           "--quiet & process=$!\n"
                                           "until [ -n \"$(squeue -h)\" ]; do sleep 0.1; done; sleep 1; kill "
                                           "-INT $(pgrep -P $process); wait $process\n"
                                           "code=$?; sleep 1; squeue -h -t R,PD; exit $code");
    EXPECT_EQ(interrupted.code, 130);
    EXPECT_EQ(interrupted.out, "") << "nothing is left in the queue";
    EXPECT_TRUE(interrupted.err.starts_with("tumble: interrupted; cancelled the jobs ")) << interrupted.err;

    // Left alone; the same command watches, with a controller that does not answer after its first question.
    const Outcome detached = run_on_cluster(command + "--detach");
    EXPECT_EQ(detached.code, 0) << detached.err;
    EXPECT_TRUE(detached.out.starts_with("block, draw: job ")) << detached.out;
    const std::string jobs = bytes("out/block/slurm/jobs");
    const Outcome watched =
        on_cluster("mkdir answers; printf '#!/bin/sh\\n%s \"$@\" && : >answers/one\\n' $(command -v squeue) "
                   ">answers/squeue\n"
                   "chmod +x answers/squeue; PATH=$PWD/answers:$PATH timeout 250 \"$TUMBLE\" " +
                   command +
                   "--quiet & process=$!\n"
                   "until [ -e answers/one ] || ! kill -0 $process; do sleep 0.05; done\n"
                   "kill -STOP $(cat cluster/controller.pid); sleep 4\n"
                   "kill -CONT $(cat cluster/controller.pid); wait $process");
    EXPECT_EQ(watched.code, 0) << watched.err;
    EXPECT_EQ(bytes("out/block/slurm/jobs"), jobs);
    expect_same_results("here", "out");
}

TEST_F(slurm, a_time_limit_that_is_reached_costs_no_frame) {
    ASSERT_EQ(tumble(slow + "--quiet --out here").code, 0);
    // Slurm counts limits in minutes and looks at them twice in one: the tasks stand still until then.
    const std::string command = slow + "--on slurm --slices 2 --slurm --time=5 --quiet";
    const Outcome late = on_cluster(
        "timeout 250 \"$TUMBLE\" " + command +
        " & process=$!\n"
        "until [ -e out/block/frames/frame_000002.png ]; do sleep 0.05; done\n"
        "for environ in $(grep -lzx \"SLURM_CONF=$(readlink cluster)/slurm.conf\" /proc/[0-9]*/environ "
        "2>/dev/null); do\n"
        "  task=${environ%/environ}; [ \"$(cat $task/comm)\" != tumble-draw ] || kill -STOP ${task#/proc/}\n"
        "done\n"
        "job=$(sed -n 's/draw //p' out/block/slurm/jobs)\n"
        "scontrol update jobid=${job}_0 EndTime=now+1; scontrol update jobid=${job}_1 EndTime=now+1; wait "
        "$process");
    EXPECT_EQ(late.code, 3);
    EXPECT_NE(late.err.find("ended without an exit code: TIMEOUT on node"), std::string::npos) << late.err;
    EXPECT_NE(late.err.find("the same command goes on"), std::string::npos) << late.err;
    expect_one_line(late.err);

    const auto drawn = fs::last_write_time(folder / "out/block/frames/frame_000001.png");
    EXPECT_EQ(run_on_cluster(command).code, 0);
    EXPECT_EQ(fs::last_write_time(folder / "out/block/frames/frame_000001.png"), drawn)
        << "what is whole is kept";
    expect_same_results("here", "out");
}

TEST_F(slurm, what_the_cluster_refuses_is_told_in_its_own_words) {
    EXPECT_EQ(tumble("run block.toml --slices 2").err, "tumble: --slices: only with --on slurm\n");
    const std::string run = "run block.toml --on slurm --slices 2 --quiet";
    const Outcome partition = run_on_cluster(run + " --slurm --partition=none");
    EXPECT_EQ(partition.code, 3);
    EXPECT_NE(partition.err.find("tumble: Slurm refuses block: "), std::string::npos) << partition.err;
    EXPECT_NE(partition.err.find("invalid partition specified: none"), std::string::npos) << partition.err;
    expect_one_line(partition.err);

    const Outcome environment = on_cluster("SBATCH_PARTITION=none \"$TUMBLE\" " + run);
    EXPECT_EQ(environment.err, partition.err);

    const Outcome without = shell("PATH=/nowhere \"$TUMBLE\" " + run);
    EXPECT_EQ(without.code, 3);
    EXPECT_TRUE(without.err.starts_with("tumble: --on slurm: there is no sbatch on this machine"))
        << without.err;

    // A node that does not see the folder, in a name space of its own.
    if (shell("unshare -m mount -t tmpfs none . 2>/dev/null").code == 0) {
        ASSERT_EQ(on_cluster("kill $(cat cluster/node2.pid); sleep 0.5; mkdir -p out\n"
                             "unshare -m sh -c 'mount -t tmpfs none out; " +
                             cluster + " node $PWD/cluster 2'")
                      .code,
                  0);
        const Outcome unseen = run_on_cluster(run + " --slurm '--nodelist=node2'");
        EXPECT_EQ(unseen.code, 3);
        EXPECT_NE(unseen.err.find("node2"), std::string::npos) << unseen.err;
        expect_one_line(unseen.err);
    }
    const Outcome munge = on_cluster("kill $(cat cluster/munge.pid); sleep 0.2; \"$TUMBLE\" " + run);
    EXPECT_EQ(munge.code, 3);
    EXPECT_NE(munge.err.find("unge"), std::string::npos) << munge.err;
    expect_one_line(munge.err);
}
