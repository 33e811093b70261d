// SPDX-License-Identifier: Apache-2.0
// Sums over the invocations of a work group, whatever the width of subgroups. The kernel sets GROUP_SIZE, its number of
// invocations, before it includes this. All invocations must call these, as they use barriers.
#ifndef CLAST_ACCEL_GROUP_GLSL
#define CLAST_ACCEL_GROUP_GLSL

shared uint group_sums[GROUP_SIZE]; // of subgroups

// The number of an invocation in its group. That of the language need not follow the order of subgroups.
uint group_lane() { return gl_SubgroupID * gl_SubgroupSize + gl_SubgroupInvocationID; }

// The sum over invocations with lower group_lane(), and the sum over all.
struct group_sum {
    uint before, all;
};

group_sum sum_over_group(uint value)
{
    barrier(); // what was read of an earlier sum has been read, and all are here
    uint within = subgroupExclusiveAdd(value);
    uint own = subgroupAdd(value);
    if (subgroupElect()) {
        group_sums[gl_SubgroupID] = own;
    }
    barrier();
    group_sum sum = group_sum(within, 0u);
    for (uint i = 0u; i < gl_NumSubgroups; i++) {
        uint part = group_sums[i];
        sum.before += i < gl_SubgroupID ? part : 0u;
        sum.all += part;
    }
    return sum;
}

// The sum over all of 64-bit values, in three parts, as subgroups need not know how to add 64 bits. GROUP_SIZE is at most 256.
uint64_t sum_over_group64(uint64_t value)
{
    uint64_t low = sum_over_group(uint(value) & 0xffffffu).all;
    uint64_t middle = sum_over_group(uint(value >> 24) & 0xffffffu).all;
    uint64_t high = sum_over_group(uint(value >> 48)).all;
    return low + (middle << 24) + (high << 48);
}

#endif
