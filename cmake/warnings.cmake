# Warnings and sanitizers for the project's own targets.
function(graspctx_compile_options target)
  target_compile_features(${target} PUBLIC cxx_std_17)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor)
  if(GRASPCTX_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  # Results are to be the same bytes on every machine: no contraction to fused multiply-add.
  target_compile_options(${target} PRIVATE -ffp-contract=off)
  if(GRASPCTX_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${GRASPCTX_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
    target_link_options(${target} PRIVATE -fsanitize=${GRASPCTX_SANITIZE})
  endif()
endfunction()
