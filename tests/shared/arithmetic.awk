# SPDX-License-Identifier: Apache-2.0
# Reads the text of a SPIR-V module. Reports arithmetic on floats that a driver may fuse (no NoContraction), and operations
# whose results differ between machines outside functions named rough_*.
/OpName / { gsub(/"/, "", $3); name[$2] = $3; next }
/OpDecorate .* NoContraction/ { kept[$2] = 1; next }
/= OpFunction / { current = name[$1]; sub(/\(.*/, "", current); next }
/OpFunctionEnd/ { current = ""; next }
current == "" { next }
current == "main" { next }
{
    operation = $3
    if (operation ~ /^(OpFAdd|OpFSub|OpFMul|OpVectorTimesScalar|OpFDiv|OpMatrixTimes.*|OpVectorTimesMatrix|OpOuterProduct)$/ && !($1 in kept)) {
        print current ": " operation " may be fused: the function needs FN, the condition a `precise bool` of its own"
        faults = 1
    }
    if (current !~ /^rough_/) {
        if (operation ~ /^(OpFDiv|OpFRem|OpFMod|OpDot|OpMatrixTimes.*|OpVectorTimesMatrix|OpOuterProduct)$/) {
            print current ": " operation " is not exact"
            faults = 1
        }
        if (operation == "OpExtInst" && $6 !~ /^(Floor|Ceil|Trunc|RoundEven|FAbs|FSign|SAbs|SSign|UMin|UMax|SMin|SMax|FindILsb|FindSMsb|FindUMsb|UnpackHalf2x16)$/) {
            print current ": " $6 " is not exact"
            faults = 1
        }
    }
}
END { exit faults }
