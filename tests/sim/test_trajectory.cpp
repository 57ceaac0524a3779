#include "sim/record/trajectory.h"
#include "tests/support/out_folder.h"

#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/record/trajectory_hdf5.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <thread>

using namespace sim;
namespace fs = std::filesystem;

namespace {

SceneDef test_scene() {
    SceneDef scene;
    scene.name = "two bodies";
    scene.text =
        "# a scene text longer than HDF5's limit for compact attributes\n" + std::string(100000, 'x');
    scene.overrides = {"step.tolerance=1e-6", "title=\"\xC3\xA4\""};
    BodyDef floor;
    floor.name = "floor";
    floor.shape = Plane{};
    BodyDef box;
    box.name = "box \xE2\x91\xA0";
    box.shape = Box{Vec3(1, 2, 3)};
    box.mass.mass = 48.0;
    scene.bodies = {floor, box};
    return scene;
}

/// Numbers that are exact in no decimal text.
Snapshot test_snapshot(std::int64_t step, std::size_t body_count) {
    Snapshot snapshot;
    snapshot.step = step;
    snapshot.time = static_cast<double>(step) / 3000;
    for (std::size_t i = 0; i < body_count; ++i) {
        const double x = std::sin(static_cast<double>(step) + static_cast<double>(i));
        snapshot.bodies.push_back({Vec3(x, 2 * x, -x), Quat(Eigen::AngleAxisd(x, Vec3(1, 2, 2) / 3)),
                                   Vec3(x / 3, x / 7, 0), Vec3(-x / 9, -0.0, 1e-300)});
    }
    return snapshot;
}

void expect_equal(const Snapshot& a, const Snapshot& b) {
    EXPECT_EQ(a.step, b.step);
    EXPECT_EQ(a.time, b.time);
    ASSERT_EQ(a.bodies.size(), b.bodies.size());
    EXPECT_EQ(state_hash(a), state_hash(b));
    for (std::size_t i = 0; i < a.bodies.size(); ++i) {
        EXPECT_EQ(a.bodies[i].position, b.bodies[i].position);
        EXPECT_EQ(a.bodies[i].orientation.coeffs(), b.bodies[i].orientation.coeffs());
        EXPECT_EQ(a.bodies[i].velocity, b.bodies[i].velocity);
        EXPECT_EQ(a.bodies[i].angular_velocity, b.bodies[i].angular_velocity);
    }
}

void write_trajectory(const fs::path& path, const SceneDef& scene, int record_count) {
    TrajectoryWriter writer(path, scene);
    for (int k = 0; k < record_count; ++k) {
        writer.append(test_snapshot(17 * k, scene.bodies.size()));
    }
    writer.finish();
}

/// Without waiting for the disk.
void write_quickly(const fs::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// Everything the reader gives, in one text. Throws Error.
std::string read_all(const fs::path& path) {
    const TrajectoryReader reader(path);
    const TrajectoryInfo& info = reader.info();
    std::string all = info.scene_name + info.scene_text + info.program_version;
    for (const auto* texts : {&info.overrides, &info.body_names, &info.body_shapes}) {
        for (const std::string& text : *texts) {
            all += text + "|";
        }
    }
    for (const double mass : info.body_masses) {
        all += std::to_string(mass);
    }
    for (std::size_t k = 0; k < reader.steps().size(); ++k) {
        all += std::to_string(state_hash(reader.read(k)));
    }
    return all;
}

} // namespace

TEST(trajectory, records_and_description_are_read_back_bit_for_bit) {
    const fs::path path = test::fresh_folder("trajectory") / "a b.h5";
    const SceneDef scene = test_scene();
    write_trajectory(path, scene, 1000); // several chunks
    EXPECT_FALSE(fs::exists(part_path(path)));
    const TrajectoryReader reader(path);
    EXPECT_EQ(reader.info().scene_name, scene.name);
    EXPECT_EQ(reader.info().scene_text, scene.text);
    EXPECT_EQ(reader.info().overrides, scene.overrides);
    EXPECT_FALSE(reader.info().program_version.empty());
    EXPECT_EQ(reader.info().body_names, (std::vector<std::string>{"floor", "box \xE2\x91\xA0"}));
    EXPECT_EQ(reader.info().body_shapes[1], shape_to_json(scene.bodies[1].shape));
    EXPECT_EQ(reader.info().body_masses, (std::vector<double>{0.0, 48.0}));
    ASSERT_EQ(reader.steps().size(), 1000u);
    for (const std::size_t k : {0u, 1u, 500u, 999u}) {
        expect_equal(reader.read(k), test_snapshot(17 * static_cast<std::int64_t>(k), 2));
    }
}

// HDF5 would write the time, in whole seconds.
TEST(trajectory, same_records_give_the_same_bytes_at_any_time) {
    const fs::path folder = test::fresh_folder("trajectory");
    write_trajectory(folder / "a.h5", test_scene(), 50);
    std::this_thread::sleep_for(std::chrono::milliseconds(1100));
    write_trajectory(folder / "b.h5", test_scene(), 50);
    EXPECT_TRUE(read_text_file(folder / "a.h5") == read_text_file(folder / "b.h5"));
}

/// Contacts that no two records and no two contacts share.
Snapshot with_contacts(Snapshot snapshot, int count) {
    for (int i = 0; i < count; ++i) {
        const float x = std::sin(static_cast<float>(snapshot.step + 7 * i));
        snapshot.contacts.push_back(
            {{i % 2, 1 - i % 2}, {x, 1 / x, -x}, {0, x, 1}, {x * 1e-30f, 0, x * 1e20f}, i % 3 == 0});
    }
    snapshot.contact_count = count;
    snapshot.impacts.assign(snapshot.contacts.rbegin(), snapshot.contacts.rbegin() + count / 2);
    return snapshot;
}

TEST(trajectory, contacts_are_read_back_bit_for_bit_as_far_as_they_were_asked_for) {
    const fs::path folder = test::fresh_folder("trajectory");
    const SceneDef scene = test_scene();
    // No contacts in some records, more than a chunk in all.
    const auto count_of = [](std::int64_t k) { return static_cast<int>(k * k % 23 * 10); };
    for (const ContactDetail detail : {ContactDetail::none, ContactDetail::count, ContactDetail::all}) {
        const fs::path path = folder / "a.h5";
        TrajectoryWriter writer(path, scene, detail);
        for (std::int64_t k = 0; k < 40; ++k) {
            writer.append(with_contacts(test_snapshot(k, 2), count_of(k)));
        }
        writer.finish();
        const TrajectoryReader reader(path);
        EXPECT_EQ(reader.contacts(), detail);
        for (std::int64_t k = 0; k < 40; ++k) {
            const Snapshot found = reader.read(static_cast<std::size_t>(k));
            const Snapshot expected = with_contacts(test_snapshot(k, 2), count_of(k));
            expect_equal(found, expected);
            EXPECT_EQ(found.contact_count, detail == ContactDetail::none ? 0 : count_of(k));
            ASSERT_EQ(found.contacts.size(), detail == ContactDetail::all ? expected.contacts.size() : 0);
            for (std::size_t i = 0; i < found.contacts.size(); ++i) {
                EXPECT_EQ(found.contacts[i].bodies, expected.contacts[i].bodies);
                EXPECT_EQ(found.contacts[i].point, expected.contacts[i].point);
                EXPECT_EQ(found.contacts[i].normal, expected.contacts[i].normal);
                EXPECT_EQ(found.contacts[i].impulse, expected.contacts[i].impulse);
                EXPECT_EQ(found.contacts[i].is_sticking, expected.contacts[i].is_sticking);
            }
            ASSERT_EQ(found.impacts.size(), detail == ContactDetail::all ? expected.impacts.size() : 0);
            for (std::size_t i = 0; i < found.impacts.size(); ++i) {
                EXPECT_EQ(found.impacts[i].bodies, expected.impacts[i].bodies);
                EXPECT_EQ(found.impacts[i].impulse, expected.impacts[i].impulse);
            }
        }
    }
}

TEST(trajectory, a_scene_without_bodies_and_overrides_is_read_back) {
    const fs::path path = test::fresh_folder("trajectory") / "a.h5";
    SceneDef scene;
    scene.name = "nothing";
    write_trajectory(path, scene, 3);
    const TrajectoryReader reader(path);
    EXPECT_EQ(reader.info().scene_text, "");
    EXPECT_TRUE(reader.info().overrides.empty());
    EXPECT_TRUE(reader.info().body_names.empty());
    expect_equal(reader.read(2), test_snapshot(34, 0));
}

TEST(trajectory, a_trajectory_that_is_not_finished_leaves_no_file) {
    const fs::path path = test::fresh_folder("trajectory") / "a.h5";
    {
        TrajectoryWriter writer(path, test_scene());
        writer.append(test_snapshot(0, 2));
        EXPECT_TRUE(fs::exists(part_path(path)));
    }
    EXPECT_FALSE(fs::exists(path));
    EXPECT_FALSE(fs::exists(part_path(path)));
}

TEST(trajectory, missing_folder_is_an_io_error_with_the_systems_reason) {
    const fs::path path = test::fresh_folder("trajectory") / "nowhere" / "a.h5";
    try {
        TrajectoryWriter writer(path, test_scene());
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::io);
        EXPECT_EQ(error.what(), "cannot write " + path.string() + ": No such file or directory");
    }
    try {
        TrajectoryReader reader(path);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::io);
        EXPECT_EQ(error.what(), "cannot read " + path.string() + ": No such file or directory");
    }
}

TEST(trajectory, a_file_that_is_no_trajectory_is_an_io_error) {
    const fs::path path = test::fresh_folder("trajectory") / "a.h5";
    write_file(path, std::string("title = \"a scene\"\n"));
    try {
        TrajectoryReader reader(path);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::io);
        EXPECT_NE(std::string(error.what()).find("not a whole trajectory"), std::string::npos)
            << error.what();
    }
}

TEST(trajectory, a_truncated_file_is_an_io_error) {
    const fs::path path = test::fresh_folder("trajectory") / "a.h5";
    write_trajectory(path, test_scene(), 20);
    const std::string whole = read_text_file(path);
    for (std::size_t size = 0; size < whole.size(); size += whole.size() / 50) {
        write_quickly(path, whole.substr(0, size));
        try {
            read_all(path);
            FAIL() << "read " << size << " of " << whole.size() << " bytes";
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::io);
        }
    }
}

// Every byte that is read carries a checksum: a changed one is found, unless it lies in unused space.
TEST(trajectory, a_changed_byte_is_an_io_error_or_changes_nothing) {
    const fs::path path = test::fresh_folder("trajectory") / "a.h5";
    SceneDef scene = test_scene();
    scene.text = "short";
    write_trajectory(path, scene, 20);
    const std::string whole = read_text_file(path);
    const std::string content = read_all(path);
    int found = 0;
    const char* stride_text = std::getenv("TUMBLE_TEST_STRIDE"); // 1 to try every byte
    const std::size_t stride =
        stride_text != nullptr ? std::strtoul(stride_text, nullptr, 10) : whole.size() / 500;
    for (std::size_t i = 0; i < whole.size(); i += stride) {
        std::string damaged = whole;
        damaged[i] = static_cast<char>(damaged[i] ^ 0x41);
        write_quickly(path, damaged);
        try {
            EXPECT_EQ(read_all(path), content) << "byte " << i;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::io);
            ++found;
        }
    }
    EXPECT_GT(found, 20);
}

/// What the reader says of a file; empty if it reads all of it.
std::string fault_of(const fs::path& path) {
    try {
        read_all(path);
        return "";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::io);
        return error.what();
    }
}

TEST(trajectory, a_name_that_no_folder_may_have_is_refused) {
    const fs::path path = test::fresh_folder("trajectory") / "a.h5";
    for (const char* name : {"..", "../up", "", "two\nlines"}) {
        SceneDef scene = test_scene();
        scene.name = name;
        write_trajectory(path, scene, 2);
        EXPECT_NE(fault_of(path).find("scene_name cannot be the name of a file"), std::string::npos) << name;
    }
}

TEST(trajectory, states_that_cannot_be_drawn_are_refused_with_record_and_body) {
    const fs::path path = test::fresh_folder("trajectory") / "a.h5";
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto fault_with = [&](auto change) {
        TrajectoryWriter writer(path, test_scene());
        writer.append(test_snapshot(0, 2));
        Snapshot bad = test_snapshot(1, 2);
        change(bad.bodies[1]);
        writer.append(bad);
        writer.finish();
        return fault_of(path);
    };
    EXPECT_EQ(fault_with([](BodySnapshot&) {}), "");
    const std::string body = "record 1 has a body 'box \xE2\x91\xA0' with ";
    const std::string no_number = body + "numbers that are not finite";
    const std::string no_turn = body + "no orientation of length one";
    EXPECT_NE(fault_with([&](BodySnapshot& b) { b.position.x() = nan; }).find(no_number), std::string::npos);
    EXPECT_NE(fault_with([&](BodySnapshot& b) { b.velocity.z() = 1.0 / 0.0; }).find(no_number), std::string::npos);
    EXPECT_NE(fault_with([&](BodySnapshot& b) { b.angular_velocity.y() = nan; }).find(no_number), std::string::npos);
    EXPECT_NE(fault_with([&](BodySnapshot& b) { b.orientation.coeffs().setZero(); }).find(no_turn), std::string::npos);
    EXPECT_NE(fault_with([&](BodySnapshot& b) { b.orientation.w() = nan; }).find(no_turn), std::string::npos);
    EXPECT_EQ(fault_with([](BodySnapshot& b) { b.orientation.coeffs() *= 1.0 + 1e-7; }), ""); // single precision
}

TEST(trajectory, another_format_is_refused_by_its_number_and_none_is_the_first) {
    const fs::path path = test::fresh_folder("trajectory") / "a.h5";
    write_trajectory(path, test_scene(), 2);
    const auto change = [&](auto work) {
        const hdf5::Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
        ASSERT_TRUE(file.is_valid());
        work(file.get());
    };
    change([](hid_t file) {
        const hdf5::Handle version(H5Aopen(file, "format_version", H5P_DEFAULT), H5Aclose);
        const std::int64_t next = 2;
        ASSERT_GE(H5Awrite(version.get(), H5T_NATIVE_INT64, &next), 0);
    });
    EXPECT_NE(fault_of(path).find("its format is 2, this program reads 1"), std::string::npos) << fault_of(path);
    change([](hid_t file) { ASSERT_GE(H5Adelete(file, "format_version"), 0); });
    EXPECT_EQ(fault_of(path), "");
}

TEST(trajectory, bodies_that_are_not_those_of_the_scene_are_named) {
    const fs::path path = test::fresh_folder("trajectory") / "a.h5";
    const SceneDef scene = test_scene();
    write_trajectory(path, scene, 1);
    const TrajectoryReader reader(path);
    const auto fault = [&](auto change) -> std::string {
        SceneDef other = scene;
        change(other.bodies[1]);
        try {
            require_same_bodies(reader.info(), other, "a.h5");
            return "";
        } catch (const Error& error) {
            return error.what();
        }
    };
    EXPECT_EQ(fault([](BodyDef&) {}), "");
    const std::string body = "a.h5: the body 'box \xE2\x91\xA0' has another ";
    EXPECT_EQ(fault([](BodyDef& b) { b.name = "box"; }), body + "name in its scene");
    EXPECT_EQ(fault([](BodyDef& b) { b.mass.mass *= 2; }), body + "mass in its scene");
    EXPECT_EQ(fault([](BodyDef& b) { b.shape = Sphere{1.0}; }), body + "shape in its scene");
}
