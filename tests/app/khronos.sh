# SPDX-License-Identifier: Apache-2.0
# What generate and export write has no error by the Khronos Group's validator, where that can be had from npm; else skipped.
. "$DATA/check.sh"
command -v node >/dev/null 2>&1 && command -v npm >/dev/null 2>&1 || {
    echo 'skipped: the Khronos validator needs node and npm'
    exit 77
}
[ -d node_modules/gltf-validator ] ||
    timeout 60 npm install --silent --fetch-retries 0 --no-audit --no-fund --no-save --prefix . gltf-validator >npm.txt 2>&1 </dev/null || {
    echo 'skipped: npm cannot fetch gltf-validator'
    exit 77
}
. "$DATA/written_files.sh"
cat >validate.js <<'END'
const fs = require('fs'), path = require('path'), validator = require('gltf-validator');
async function validate(file) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
        uri: file,
        externalResourceFunction: async uri =>
            new Uint8Array(fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(uri)))),
    });
    for (const m of report.issues.messages.filter(m => m.severity === 0)) {
        console.log(`${file}: ${m.code} at ${m.pointer}: ${m.message}`);
    }
    return report.issues.numErrors;
}
(async () => {
    let errors = 0;
    for (const file of process.argv.slice(2)) {
        errors += await validate(file);
    }
    console.log(`${process.argv.length - 2} files, ${errors} errors`);
    process.exit(errors === 0 ? 0 : 1);
})();
END
# shellcheck disable=SC2086 # a list of names
node validate.js $files >report.txt 2>&1 || wrong "$(cat report.txt)"
grep -q '^6 files, 0 errors$' report.txt || wrong "$(cat report.txt)"
finish
