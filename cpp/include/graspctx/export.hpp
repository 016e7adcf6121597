#pragma once
/// Symbol visibility of the shared libraries.
#define GRASPCTX_EXPORT __attribute__((visibility("default")))
