#include "render/picture/passes.h"
#include "sim/base/error.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>

#include <cstring>
#include <exception>

namespace render {

namespace {

/// A file in memory.
class Bytes : public Imf::OStream {
public:
    Bytes() : Imf::OStream("a frame's passes") {}

    void write(const char* from, int count) override {
        const std::size_t end = at_ + static_cast<std::size_t>(count);
        bytes.resize(std::max(bytes.size(), end));
        std::memcpy(bytes.data() + at_, from, static_cast<std::size_t>(count));
        at_ = end;
    }
    std::uint64_t tellp() override { return at_; }
    void seekp(std::uint64_t at) override { at_ = at; }

    std::vector<std::uint8_t> bytes;

private:
    std::size_t at_ = 0;
};

} // namespace

std::vector<std::uint8_t> encode_exr(const std::vector<Channel>& channels, int width, int height) {
    constexpr std::size_t value_bytes = 4; // of floats and counts alike
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    Imf::Header header(width, height);
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer buffer;
    for (const Channel& channel : channels) {
        const bool is_count = channel.values.empty();
        CHECK((is_count ? channel.counts.size() : channel.values.size()) == pixels);
        const Imf::PixelType type = is_count ? Imf::UINT : Imf::FLOAT;
        header.channels().insert(channel.name, Imf::Channel(type));
        const void* first = is_count ? static_cast<const void*>(channel.counts.data()) : channel.values.data();
        // The library takes what it writes and what it reads by the same type.
        char* base = const_cast<char*>(static_cast<const char*>(first));
        buffer.insert(channel.name, Imf::Slice(type, base, value_bytes, value_bytes * static_cast<std::size_t>(width)));
    }
    Bytes stream;
    try {
        Imf::OutputFile file(stream, header);
        file.setFrameBuffer(buffer);
        file.writePixels(height);
    } catch (const std::exception& error) {
        throw sim::Error(sim::ExitCode::io, std::string("OpenEXR cannot encode a frame's passes: ") + error.what());
    }
    return std::move(stream.bytes);
}

} // namespace render
