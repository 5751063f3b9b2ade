//! The pipeline cache on disk. A file that is damaged, truncated or of another driver is passed over, never trusted.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ash::vk;

use super::{Device, failed};
use crate::error::Result;

const MAGIC: &[u8; 8] = b"LMPYPSO1";

/// A `VkPipelineCache` that remembers its file.
pub struct PipelineCache {
    /// Handle.
    pub raw: vk::PipelineCache,
    /// True where a good file was found.
    pub warm: bool,
    path: Option<PathBuf>,
    loaded_bytes: usize,
    device: Arc<Device>,
}

fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// Where caches go: `$XDG_CACHE_HOME/lampyris`, else `$HOME/.cache/lampyris`; `None` where neither is set.
pub fn folder() -> Option<PathBuf> {
    let base = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from).filter(|p| p.is_absolute());
    let base = base.or_else(|| std::env::var_os("HOME").map(|h| PathBuf::from(h).join(".cache")))?;
    Some(base.join("lampyris"))
}

/// The cache's own bytes, if `file` is whole: magic, checksum, data.
pub fn unpack(file: &[u8]) -> Option<&[u8]> {
    let (magic, rest) = file.split_at_checked(8)?;
    let (sum, data) = rest.split_at_checked(8)?;
    (magic == MAGIC && checksum(data).to_le_bytes() == sum).then_some(data)
}

/// The file for a cache's bytes.
pub fn pack(data: &[u8]) -> Vec<u8> {
    [MAGIC.as_slice(), &checksum(data).to_le_bytes(), data].concat()
}

impl PipelineCache {
    /// Opens the cache of this device and driver version, or an empty one.
    pub fn create(device: &Arc<Device>) -> Result<Self> {
        let facts = &device.facts;
        let uuid: String = facts.cache_uuid.iter().map(|b| format!("{b:02x}")).collect();
        let file = format!("pipelines-{uuid}-{:x}-{}.bin", facts.driver_version, env!("CARGO_PKG_VERSION"));
        let path = folder().map(|f| f.join(file));
        let stored = path.as_ref().and_then(|p| fs::read(p).ok());
        let data = stored.as_deref().and_then(unpack).unwrap_or(&[]);
        let create = |data: &[u8]| {
            let info = vk::PipelineCacheCreateInfo::default().initial_data(data);
            // SAFETY: the driver checks the header of the data, whose checksum is right.
            unsafe { device.raw.create_pipeline_cache(&info, None) }
        };
        let (raw, loaded) = match create(data) {
            Ok(raw) => (raw, data.len()),
            Err(_) => (create(&[]).map_err(failed("creating the pipeline cache"))?, 0),
        };
        Ok(Self { raw, warm: loaded > 0, path, loaded_bytes: loaded, device: device.clone() })
    }

    /// Writes the cache beside its file and renames it; a cache that cannot be written is only slower next time.
    pub fn save(&self) {
        let Some(path) = &self.path else { return };
        // SAFETY: the handle is alive.
        let Ok(data) = (unsafe { self.device.raw.get_pipeline_cache_data(self.raw) }) else { return };
        if data.len() == self.loaded_bytes {
            return;
        }
        let _ = write_beside(path, &pack(&data));
    }
}

fn write_beside(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let part = path.with_extension(format!("{}.part", std::process::id()));
    fs::write(&part, bytes).and_then(|()| fs::rename(&part, path)).inspect_err(|_| drop(fs::remove_file(&part)))
}

impl Drop for PipelineCache {
    fn drop(&mut self) {
        self.save();
        // SAFETY: pipelines do not need the cache they were made with.
        unsafe { self.device.raw.destroy_pipeline_cache(self.raw, None) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damaged_cache_files_are_passed_over() {
        let file = pack(b"pipelines");
        assert_eq!(unpack(&file), Some(b"pipelines".as_slice()));
        for length in 0..file.len() {
            assert_eq!(unpack(&file[..length]), None, "truncated to {length}");
        }
        for bit in 0..file.len() * 8 {
            let mut flipped = file.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(unpack(&flipped), None, "bit {bit}");
        }
    }
}
