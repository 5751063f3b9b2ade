//! Patch product: bounced light of all patches in one product with bounces that were summed beforehand.
//!
//! Reads: the matrix (words, a texel buffer or an image), what patches send at first. Writes: their light.
//! Group shape: as many threads as run in step, 32 at most, for four rows; their sums are added in a fixed order. Limits: a matrix that is bound at once; the plan refuses others.
//! CPU twin: `radiosity/codec/coded.rs`.

use bytemuck::bytes_of;

use super::nearest_sampler;
use super::resources::BouncedHandles;
use crate::graph::access::{ComputeSampled, ComputeStorageRead, ComputeStorageWrite, ComputeTexel};
use crate::graph::{BufferHandle, ComputePipeline, Groups, Work};
use crate::plan::Bounced;
use crate::plan::bounced::Carried;
use crate::shaders::radiosity::patch_product;
use crate::shared::{MOST_GROUPS, ProductPush};

/// The dispatch.
pub(super) fn work(
    bounced: &Bounced,
    of: &BouncedHandles,
    [before, after]: [BufferHandle; 2],
    push: ProductPush,
) -> Work {
    let matrix = &bounced.matrix;
    let set = patch_product::Bindings {
        words: ComputeStorageRead(of.matrix),
        before: ComputeStorageRead(before),
        after: ComputeStorageWrite(after),
        bounced_matrix_texels: Some(ComputeTexel(of.matrix)),
        bounced_sent: Some(ComputeTexel(before)),
        bounced_matrix_image: of.matrix_image.map(|image| ComputeSampled(image, nearest_sampler())),
    };
    let spec = patch_product::Spec {
        CODEC: matrix.codec,
        MATRIX_PATH: matrix.path,
        GROUP_SIZE: bounced.lanes,
        COLUMNS: bounced.carried == Carried::Changes,
    };
    let groups = push.count.div_ceil(4);
    Work::Dispatch {
        pipeline: ComputePipeline { program: &patch_product::PROGRAM, constants: spec.values() },
        bindings: set.list(),
        push: bytes_of(&push).to_vec(),
        groups: Groups::Fixed([groups.min(MOST_GROUPS), groups.div_ceil(MOST_GROUPS), 1]),
    }
}
