#pragma once
/// Which of libavcodec's encoders a film gets, and with which options.
#include "render/film/av_handles.h"
#include "render/film/video_writer.h"

namespace render {

/// By its name, or automatic_encoder. Throws Error (usage): which names there are.
const AVCodec& find_encoder(const std::string& name);

/// An encoder that takes pictures of this size, >= 1 and even. is_headed_by_file: what it needs to be read is written
/// once, at the file's head. Throws Error (usage): which names there are, or why the encoder refuses.
CodecContext open_encoder(const VideoSettings& settings, int width, int height, bool is_headed_by_file);

} // namespace render
