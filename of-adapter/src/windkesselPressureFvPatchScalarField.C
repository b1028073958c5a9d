/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "windkesselPressureFvPatchScalarField.H"
#include "addToRunTimeSelectionTable.H"
#include "fvPatchFieldMapper.H"
#include "surfaceFields.H"
#include "volFields.H"

// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

Foam::windkesselPressureFvPatchScalarField::windkesselPressureFvPatchScalarField
(
    const fvPatch& p,
    const DimensionedField<scalar, volMesh>& iF
)
:
    fixedValueFvPatchScalarField(p, iF),
    resistance_(1),
    compliance_(0),
    density_(1),
    phiName_("phi"),
    ramp_(),
    oldPressure_(0),
    timeIndex_(-1),
    timeStep_(0)
{}


Foam::windkesselPressureFvPatchScalarField::windkesselPressureFvPatchScalarField
(
    const fvPatch& p,
    const DimensionedField<scalar, volMesh>& iF,
    const dictionary& dict
)
:
    fixedValueFvPatchScalarField(p, iF, dict, false),
    resistance_(dict.get<scalar>("resistance")),
    compliance_(dict.get<scalar>("compliance")),
    density_(dict.get<scalar>("density")),
    phiName_(dict.lookupOrDefault<word>("phi", "phi")),
    ramp_(dict.found("ramp") ? Function1<scalar>::New("ramp", dict) : nullptr),
    oldPressure_(dict.get<scalar>("pressure")),
    timeIndex_(-1),
    timeStep_(0)
{
    if (resistance_ <= 0 || compliance_ < 0 || density_ <= 0)
    {
        FatalIOErrorInFunction(dict)
            << "A windkessel needs resistance > 0, compliance >= 0 and"
            << " density > 0; found " << resistance_ << ", " << compliance_
            << ", " << density_ << exit(FatalIOError);
    }
    if (dict.found("value"))
    {
        fvPatchField<scalar>::operator=(scalarField("value", dict, p.size()));
    }
    else
    {
        const scalar factor =
            ramp_.valid() ? ramp_->value(db().time().timeOutputValue()) : 1;
        fvPatchField<scalar>::operator=(factor*oldPressure_/density_);
    }
}


Foam::windkesselPressureFvPatchScalarField::windkesselPressureFvPatchScalarField
(
    const windkesselPressureFvPatchScalarField& other,
    const fvPatch& p,
    const DimensionedField<scalar, volMesh>& iF,
    const fvPatchFieldMapper& mapper
)
:
    fixedValueFvPatchScalarField(other, p, iF, mapper),
    resistance_(other.resistance_),
    compliance_(other.compliance_),
    density_(other.density_),
    phiName_(other.phiName_),
    ramp_(other.ramp_.clone()),
    oldPressure_(other.oldPressure_),
    timeIndex_(other.timeIndex_),
    timeStep_(other.timeStep_)
{}


Foam::windkesselPressureFvPatchScalarField::windkesselPressureFvPatchScalarField
(
    const windkesselPressureFvPatchScalarField& other
)
:
    fixedValueFvPatchScalarField(other),
    resistance_(other.resistance_),
    compliance_(other.compliance_),
    density_(other.density_),
    phiName_(other.phiName_),
    ramp_(other.ramp_.clone()),
    oldPressure_(other.oldPressure_),
    timeIndex_(other.timeIndex_),
    timeStep_(other.timeStep_)
{}


Foam::windkesselPressureFvPatchScalarField::windkesselPressureFvPatchScalarField
(
    const windkesselPressureFvPatchScalarField& other,
    const DimensionedField<scalar, volMesh>& iF
)
:
    fixedValueFvPatchScalarField(other, iF),
    resistance_(other.resistance_),
    compliance_(other.compliance_),
    density_(other.density_),
    phiName_(other.phiName_),
    ramp_(other.ramp_.clone()),
    oldPressure_(other.oldPressure_),
    timeIndex_(other.timeIndex_),
    timeStep_(other.timeStep_)
{}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void Foam::windkesselPressureFvPatchScalarField::advance()
{
    const label now = db().time().timeIndex();
    if (timeIndex_ == now)
    {
        return;
    }
    if (timeIndex_ >= 0)
    {
        // The flux is still that of the step before: nothing has been solved
        // since. Time::deltaT0 is how long that step was when it began.
        const scalar dt = timeStep_;
        const scalar Q =
            gSum(patch().lookupPatchField<surfaceScalarField, scalar>(phiName_));
        oldPressure_ =
            (oldPressure_*compliance_/dt + Q)
           /(compliance_/dt + 1/resistance_);
    }
    timeIndex_ = now;
}


Foam::scalar Foam::windkesselPressureFvPatchScalarField::pressure() const
{
    if (timeIndex_ != db().time().timeIndex())
    {
        return oldPressure_;
    }
    const scalar dt = db().time().deltaTValue();
    const scalar Q =
        gSum(patch().lookupPatchField<surfaceScalarField, scalar>(phiName_));

    return
        (oldPressure_*compliance_/dt + Q)/(compliance_/dt + 1/resistance_);
}


void Foam::windkesselPressureFvPatchScalarField::updateCoeffs()
{
    if (updated())
    {
        return;
    }
    advance();
    timeStep_ = db().time().deltaTValue();
    const scalar factor =
        ramp_.valid() ? ramp_->value(db().time().timeOutputValue()) : 1;
    operator==(factor*pressure()/density_);

    fixedValueFvPatchScalarField::updateCoeffs();
}


void Foam::windkesselPressureFvPatchScalarField::write(Ostream& os) const
{
    fvPatchScalarField::write(os);
    os.writeEntry("resistance", resistance_);
    os.writeEntry("compliance", compliance_);
    os.writeEntry("density", density_);
    os.writeEntryIfDifferent<word>("phi", "phi", phiName_);
    if (ramp_.valid())
    {
        ramp_->writeData(os);
    }
    os.writeEntry("pressure", pressure());
    writeEntry("value", os);
}


namespace Foam
{
    makePatchTypeField
    (
        fvPatchScalarField,
        windkesselPressureFvPatchScalarField
    );
}


// ************************************************************************* //
