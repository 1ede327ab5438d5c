//! Logged columns: the state of air and machine at each reading.

/// A column of `lengths.csv` with the state of air or machine.
#[derive(Debug, Clone, PartialEq)]
pub struct LoggedColumn {
    /// Its name in the file, such as `air_temp_c` or `machine_temp_spindle_c`.
    pub name: String,
    /// One value for each reading, in their order and in the unit of the name; none where the cell is empty.
    pub values: Vec<Option<f64>>,
}

impl LoggedColumn {
    /// What the column holds; none if its name is not one of the format.
    pub fn quantity(&self) -> Option<LoggedQuantity> {
        LoggedQuantity::of_column(&self.name)
    }
}

/// What a logged column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoggedQuantity {
    /// Temperature of the air, °C.
    AirTemperature,
    /// Pressure of the air, hPa.
    AirPressure,
    /// Relative humidity of the air, %.
    AirHumidity,
    /// Temperature somewhere in the machine, °C.
    MachineTemperature,
}

/// The logged columns of the format. `<name>` stands for any text.
pub(crate) const LOGGED_COLUMNS: [&str; 5] = [
    "air_temp_c",
    "air_pressure_hpa",
    "air_humidity_pct",
    "machine_temp_c",
    "machine_temp_<name>_c",
];

impl LoggedQuantity {
    /// Whether a column of that name holds temperatures.
    pub fn is_temperature(name: &str) -> bool {
        let quantity = Self::of_column(name);
        matches!(
            quantity,
            Some(Self::AirTemperature | Self::MachineTemperature)
        )
    }

    /// What a column of that name holds; none if the format has no such logged column.
    pub fn of_column(name: &str) -> Option<Self> {
        use LoggedQuantity::{AirHumidity, AirPressure, AirTemperature, MachineTemperature};
        let quantities = [
            AirTemperature,
            AirPressure,
            AirHumidity,
            MachineTemperature,
            MachineTemperature,
        ];
        let mut known = LOGGED_COLUMNS.iter().zip(quantities);
        let found = known.find(|(column, _)| is_column(column, name));
        found.map(|(_, quantity)| quantity)
    }
}

/// Whether `name` is the column `known` of the format, in which `<name>` stands for any text.
pub(crate) fn is_column(known: &str, name: &str) -> bool {
    match known.split_once("<name>") {
        Some((before, after)) => name
            .strip_prefix(before)
            .and_then(|rest| rest.strip_suffix(after))
            .is_some_and(|own| !own.is_empty()),
        None => known == name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_number_of_machine_temperatures_have_a_name() {
        let machine = Some(LoggedQuantity::MachineTemperature);
        for name in ["machine_temp_c", "machine_temp_x_c", "machine_temp_z_c_c"] {
            assert_eq!(LoggedQuantity::of_column(name), machine, "{name}");
        }
        let pressure = Some(LoggedQuantity::AirPressure);
        assert_eq!(LoggedQuantity::of_column("air_pressure_hpa"), pressure);
        for name in ["machine_temp__c", "machine_temp_x", "air_temp_x_c", "X"] {
            assert_eq!(LoggedQuantity::of_column(name), None, "{name}");
        }
    }
}
