#include "render/picture/picture_reader.h"

#include "sim/base/error.h"

#include <cstring>
#include <utility>

namespace render {

namespace {

constexpr std::size_t pixel_bytes = 4; // of colours, part numbers and depths alike

} // namespace

PictureReader::PictureReader(int width, int height, bool reads_ids, bool is_buffered)
    : width_(width), height_(height), reads_ids_(reads_ids), is_buffered_(is_buffered) {
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
}

std::size_t PictureReader::Read::bytes() const {
    return pixel_bytes * static_cast<std::size_t>(rect.width) * static_cast<std::size_t>(rect.height);
}

void PictureReader::Read::into(void* to) const {
    glReadBuffer(format == GL_RED_INTEGER ? GL_COLOR_ATTACHMENT1 : GL_COLOR_ATTACHMENT0);
    glReadPixels(rect.x, rect.y, rect.width, rect.height, format, type, to);
}

void PictureReader::start(GlBuffer& buffer, const Read& read) const {
    const bool is_new = buffer.get() == 0;
    if (is_new) {
        buffer = GlBuffer::create();
    }
    glBindBuffer(GL_PIXEL_PACK_BUFFER, buffer.get());
    if (is_new) {
        const std::size_t bytes = Read{whole(), read.format, read.type}.bytes();
        glBufferData(GL_PIXEL_PACK_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, GL_STREAM_READ);
    }
    read.into(nullptr); // into the buffer, without waiting
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
}

template <class Value>
void PictureReader::take(const GlBuffer& buffer, const Read& read, std::vector<Value>& values) const {
    values.resize(read.bytes() / sizeof(Value));
    if (!is_buffered_) {
        read.into(values.data());
        return;
    }
    glBindBuffer(GL_PIXEL_PACK_BUFFER, buffer.get());
    const void* memory =
        glMapBufferRange(GL_PIXEL_PACK_BUFFER, 0, static_cast<GLsizeiptr>(read.bytes()), GL_MAP_READ_BIT);
    if (memory != nullptr) { // else the caller finds OpenGL's error
        std::memcpy(values.data(), memory, read.bytes());
        glUnmapBuffer(GL_PIXEL_PACK_BUFFER);
    }
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
}

void PictureReader::begin(const glm::mat4& clip_from_world, const PixelRect& rect, bool has_depth) {
    CHECK(begun_.size() < static_cast<std::size_t>(capacity()));
    if (free_.empty()) {
        free_.emplace_back();
    }
    Begun begun = std::move(free_.front());
    free_.pop_front();
    begun.clip_from_world = clip_from_world;
    begun.rect = rect;
    begun.has_depth = has_depth;
    if (is_buffered_) {
        start(begun.color, {rect, GL_RGBA, GL_UNSIGNED_BYTE});
        if (reads_ids_) {
            start(begun.ids, {rect, GL_RED_INTEGER, GL_UNSIGNED_INT});
        }
        if (has_depth) {
            start(begun.depth, {whole(), GL_DEPTH_COMPONENT, GL_FLOAT});
        }
    }
    begun_.push_back(std::move(begun));
}

void PictureReader::finish(RawPicture& raw, DepthPicture& depth) {
    CHECK(!begun_.empty());
    Begun begun = std::move(begun_.front());
    begun_.pop_front();
    raw.x = begun.rect.x;
    raw.y = begun.rect.y;
    raw.width = begun.rect.width;
    raw.height = begun.rect.height;
    take(begun.color, {begun.rect, GL_RGBA, GL_UNSIGNED_BYTE}, raw.rgba);
    if (reads_ids_) {
        take(begun.ids, {begun.rect, GL_RED_INTEGER, GL_UNSIGNED_INT}, raw.ids);
    }
    if (begun.has_depth) {
        depth.width = width_;
        depth.height = height_;
        depth.clip_from_world = begun.clip_from_world;
        take(begun.depth, {whole(), GL_DEPTH_COMPONENT, GL_FLOAT}, depth.depth);
    }
    free_.push_back(std::move(begun));
}

} // namespace render
