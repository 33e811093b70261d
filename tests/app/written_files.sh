# SPDX-License-Identifier: Apache-2.0
# Sourced by tests: makes the glTF files that the command writes, small ones, and names them in $files.
"$CLAST" generate --quiet --detail 0.02 canyon canyon || wrong "generate canyon"
"$CLAST" generate --quiet --detail 0.02 cloister cloister || wrong "generate cloister"
for ending in gltf glb; do
    "$CLAST" export --quiet --width 64 --height 36 canyon/scene.json canyon.$ending || wrong "export canyon.$ending"
    "$CLAST" export --quiet --width 64 --height 36 --metric fixed --segment 2 cloister/scene.json cloister.$ending ||
        wrong "export cloister.$ending"
done
files='canyon/canyon.gltf cloister/cloister.gltf canyon.gltf canyon.glb cloister.gltf cloister.glb'
