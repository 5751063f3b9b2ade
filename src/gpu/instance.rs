//! The Vulkan instance, the validation layers and where their messages go.

use std::ffi::{CStr, c_char, c_void};
use std::sync::{Arc, Mutex};

use ash::{Entry, ext, khr, vk};

use super::failed;
use crate::error::{Error, Result};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// How an instance is made.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Validation and synchronization validation; an error without the layer.
    pub validate: bool,
    /// Device or driver name contains this, ignoring case.
    pub driver: Option<String>,
}

/// Messages of the validation layer, in order.
#[derive(Debug, Default)]
pub struct Messages(Mutex<Vec<String>>);

impl Messages {
    /// Takes what has come so far.
    pub fn take(&self) -> Vec<String> {
        self.0.lock().map(|mut list| std::mem::take(&mut *list)).unwrap_or_default()
    }
}

/// Instance, debug messenger and the messages it caught.
pub struct Instance {
    /// Loaded entry points; kept alive for the instance.
    pub entry: Entry,
    /// The instance.
    pub raw: ash::Instance,
    /// True where `VK_EXT_debug_utils` is on.
    pub debug_utils: bool,
    /// True where the validation layer is on.
    pub validation: bool,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    messages: Arc<Messages>,
}

/// The loader's remark, not the layer's, on how ash asks for the functions of extensions that nobody here calls.
const LOADER_REMARK: &str = "vkGetDeviceProcAddr(): pName is trying to grab";

unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: `user` is the `Messages` that the instance keeps until the messenger is gone; `data` is valid for the call.
    unsafe {
        let messages = &*user.cast::<Messages>();
        let text = (*data).p_message;
        if !text.is_null()
            && let Ok(mut list) = messages.0.lock()
        {
            let text = CStr::from_ptr(text).to_string_lossy().into_owned();
            if !text.starts_with(LOADER_REMARK) {
                list.push(text);
            }
        }
    }
    vk::FALSE
}

fn has_layer(entry: &Entry) -> bool {
    // SAFETY: no preconditions.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap_or_default();
    layers.iter().any(|l| l.layer_name_as_c_str() == Ok(VALIDATION_LAYER))
}

fn has_extension(entry: &Entry, layer: Option<&CStr>, name: &CStr) -> bool {
    // SAFETY: `layer`, where given, names a layer that is there.
    let list = unsafe { entry.enumerate_instance_extension_properties(layer) }.unwrap_or_default();
    list.iter().any(|e| e.extension_name_as_c_str() == Ok(name))
}

impl Instance {
    /// Loads Vulkan and makes an instance of version 1.3.
    ///
    /// # Errors
    /// No loader, a loader below 1.3, no driver, or `validate` without the layer.
    pub fn create(options: &Options) -> Result<Self> {
        // SAFETY: loading the system's Vulkan loader runs its initialisers only.
        let entry = unsafe { Entry::load() }.map_err(|e| {
            Error::new(format!("no Vulkan loader was found ({e}); install one, on Debian the package libvulkan1"))
        })?;
        let validation = options.validate;
        if validation && !has_layer(&entry) {
            return Err(Error::new(
                "--validate needs VK_LAYER_KHRONOS_validation, which is not installed (on Debian: vulkan-validationlayers)",
            ));
        }
        let debug_utils = has_extension(&entry, None, ext::debug_utils::NAME)
            || (validation && has_extension(&entry, Some(VALIDATION_LAYER), ext::debug_utils::NAME));
        let portability = has_extension(&entry, None, khr::portability_enumeration::NAME);
        let mut extensions: Vec<*const c_char> = Vec::new();
        if debug_utils {
            extensions.push(ext::debug_utils::NAME.as_ptr());
        }
        if validation && has_extension(&entry, Some(VALIDATION_LAYER), ext::validation_features::NAME) {
            extensions.push(ext::validation_features::NAME.as_ptr());
        }
        let mut flags = vk::InstanceCreateFlags::empty();
        if portability {
            extensions.push(khr::portability_enumeration::NAME.as_ptr());
            flags |= vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR;
        }
        let layers = if validation { vec![VALIDATION_LAYER.as_ptr()] } else { Vec::new() };
        let application = vk::ApplicationInfo::default()
            .application_name(c"lampyris")
            .engine_name(c"lampyris")
            .api_version(vk::API_VERSION_1_3);
        let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_extension_names(&extensions)
            .enabled_layer_names(&layers)
            .flags(flags);
        if validation {
            info = info.push_next(&mut features);
        }
        // SAFETY: every pointer in `info` lives until the call returns.
        let raw = unsafe { entry.create_instance(&info, None) }.map_err(|e| match e {
            // The loader says so both where no driver is there and where none is of version 1.3.
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => Error::new(NO_DRIVER),
            other => failed("creating a Vulkan 1.3 instance")(other),
        })?;
        let messages = Arc::<Messages>::default();
        let mut instance = Self { entry, raw, debug_utils, validation, messenger: None, messages };
        if validation && !debug_utils {
            return Err(Error::new("--validate needs VK_EXT_debug_utils, which neither loader nor layer has"));
        }
        if validation {
            instance.listen()?;
        }
        Ok(instance)
    }

    fn listen(&mut self) -> Result<()> {
        let functions = ext::debug_utils::Instance::new(&self.entry, &self.raw);
        let user = Arc::as_ptr(&self.messages);
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
            .pfn_user_callback(Some(on_message))
            .user_data(user.cast_mut().cast());
        // SAFETY: the instance keeps `messages` until the messenger is gone.
        let messenger = unsafe { functions.create_debug_utils_messenger(&info, None) }
            .map_err(failed("creating the debug messenger"))?;
        self.messenger = Some((functions, messenger));
        Ok(())
    }

    /// Messages of the validation layer.
    pub fn messages(&self) -> Arc<Messages> {
        self.messages.clone()
    }
}

/// What a machine without any driver is told.
pub const NO_DRIVER: &str =
    "no Vulkan driver was found; install one (on Debian mesa-vulkan-drivers has a software one) or set VK_DRIVER_FILES";

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: children of the instance are gone: `Device` holds the instance and drops first.
        unsafe {
            if let Some((functions, messenger)) = self.messenger.take() {
                functions.destroy_debug_utils_messenger(messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}
